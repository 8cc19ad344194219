"""The simulated robot of examples/diff_drive with its agent, as a demonstrator sees them."""

from __future__ import annotations

import contextlib
import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import warm_hitab
from geometry_msgs.msg import Twist
from hitab_msgs.msg import AgentStatus, TransitionEvent
from mentions import ROOT
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from hitab_client import RosLink, SwarmClient, SwarmError
from hitab_client.connecting.domain_ids import reserved
from hitab_client.stops import Stops
from hitab_core.operations import DiscardTraining, Perform
from hitab_ros import EmergencySwitch, qos
from hitab_ros.messages.stamps import seconds_of

EXAMPLE = ROOT / "examples/diff_drive"
DOMAIN = "diff_drive.domain:DOMAIN"
ROBOT = "robot_1"
SECONDS = 60.0


def is_still(velocity: Twist) -> bool:
    return velocity.linear.x == 0.0 and velocity.angular.z == 0.0


@dataclass
class Desk:
    """A robot with its agent, each a process of its own, and somebody who looks on."""

    link: RosLink
    agents: SwarmClient
    switch: EmergencySwitch
    environment: dict[str, str]
    robot: subprocess.Popen[bytes]
    agent: subprocess.Popen[bytes]
    odometry: Odometry | None = None
    scan: LaserScan | None = None
    velocities: list[Twist] = field(default_factory=list)
    changes: list[tuple[str, str]] = field(default_factory=list)
    nearest: float = math.inf

    def watch(self) -> None:
        """Look at what the robot tells."""
        subscribe, topic = self.link.subscribe, f"/{ROBOT}/{{}}".format
        subscribe(Odometry, topic("odom"), self._see_odometry, qos_profile_sensor_data)
        subscribe(LaserScan, topic("scan"), self._see_scan, qos_profile_sensor_data)
        subscribe(Twist, topic("cmd_vel"), self.velocities.append, qos.EVENTS)
        subscribe(TransitionEvent, topic("transitions"), self._see_change, qos.EVENTS)

    def _see_odometry(self, odometry: Odometry) -> None:
        self.odometry = odometry

    def _see_scan(self, scan: LaserScan) -> None:
        self.scan = scan
        self.nearest = min(self.nearest, *scan.ranges)

    def _see_change(self, event: TransitionEvent) -> None:
        self.changes.append((event.from_state, event.to_state))

    @property
    def status(self) -> AgentStatus:
        return self.agents.statuses[ROBOT]

    @property
    def free_ahead(self) -> float:
        """How far it is to what is straight ahead, m."""
        return math.nan if self.scan is None else self.scan.ranges[len(self.scan.ranges) // 2]

    def until(self, condition: Callable[[], Any], each: Callable[[], Any] = lambda: None) -> None:
        deadline = time.monotonic() + SECONDS
        while not condition():
            assert time.monotonic() < deadline, "it did not happen in time"
            each()
            self.link.spin(0.02)

    def until_later(self, seconds: float) -> None:
        """Wait until the robot has lived on for so long."""
        assert self.odometry is not None
        after = seconds_of(self.odometry.header.stamp) + seconds
        self.until(lambda: seconds_of(self.odometry.header.stamp) > after)

    def await_value(self, feature: str) -> None:
        """Wait until the agent has heard the sensor that a feature is read from."""

        def value() -> float:
            answer = self.agents.read_features(ROBOT, [feature])
            return next(r.value for r in answer.readings if r.feature == feature)

        self.until(lambda: not math.isnan(value()))

    def moves(self, ahead: float = 0.0, turn: float = 0.0) -> bool:
        """Whether the robot was last sent about this velocity; at first, it stands still."""
        last = self.velocities[-1] if self.velocities else Twist()
        return abs(last.linear.x - ahead) < 1e-6 and abs(last.angular.z - turn) < 1e-6

    def stays_where_it_is(self) -> bool:
        """Whether the robot stands still for a while."""
        self.velocities.clear()
        self.link.spin_until(lambda: False, 1.5)
        return all(map(is_still, self.velocities))

    def has_fault(self, text: str) -> bool:
        return any(text in fault for fault in self.status.faults)

    def perform(self, behavior: str) -> None:
        """Have the robot move."""
        self.agents.do(ROBOT, Perform(behavior))
        self.until(lambda: not self.moves())

    def arm(self) -> None:
        """Let the robot act, as a person does who has looked at it, once it may."""

        def armed() -> bool:
            with contextlib.suppress(SwarmError):
                Stops(self.link).arm(ROBOT, SECONDS)
                return True
            return False

        self.until(armed)

    def rest(self) -> None:
        """Have everything as it was at first: armed, at rest, and nothing is trained."""
        self.switch.set(False, "the test")
        with contextlib.suppress(SwarmError):  # nothing is trained
            self.agents.do(ROBOT, DiscardTraining())
        self.agents.do(ROBOT, Perform())
        self.until(self.moves)
        self.arm()
        self.until(lambda: not self.status.faults)
        self.changes.clear()

    def hitab(self, *arguments: str, status: int = 0) -> str:
        """Run a command; return all that it says."""
        command = ("hitab", *arguments)
        code, out, err = warm_hitab.run(command, ROOT, self.environment, SECONDS)
        assert code == status, err
        return out + err


@contextlib.contextmanager
def desk_with(folder: Path, domain: str = DOMAIN) -> Iterator[Desk]:
    """Start the robot and its agent, which may act.

    Args:
        folder: for the agent's files; modules in it can be imported.
        domain: of the agent.
    """
    with contextlib.ExitStack() as stack:
        domain_id = stack.enter_context(reserved())
        link = stack.enter_context(RosLink(domain_id))
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "PYTHONPATH": os.pathsep.join(
                [str(EXAMPLE), str(folder), os.environ.get("PYTHONPATH", "")]
            ),
            "COLUMNS": "200",
            "LINES": "50",
            "TERM": "xterm",
        }

        def start(module: str, *parameters: str) -> subprocess.Popen[bytes]:
            command = [sys.executable, "-m", module, "--ros-args", "-r", f"__ns:=/{ROBOT}"]
            process = subprocess.Popen([*command, *parameters], env=environment)
            stack.callback(process.wait)
            stack.callback(process.kill)
            stack.callback(process.send_signal, signal.SIGCONT)
            return process

        robot = start("diff_drive.simulated_robot")
        given = ("-p", f"domain:={domain}", "-p", f"state_dir:={folder}")
        agent = start("hitab_agent.agent_main", *given)
        switch = EmergencySwitch(link.node)
        desk = Desk(link, SwarmClient(link, [ROBOT]), switch, environment, robot, agent)
        desk.watch()
        desk.agents.await_agent(ROBOT, SECONDS)
        desk.until(lambda: desk.odometry and desk.scan)
        desk.arm()
        yield desk
