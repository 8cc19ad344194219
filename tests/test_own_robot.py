"""A robot of one's own, examples/diff_drive: trained by topics, and safe when something fails."""

import math
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from hitab_msgs.msg import TransitionEvent
from hitab_msgs.srv import ReadFeatures
from nav_msgs.msg import Odometry
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from hitab_client.domain_ids import reserved
from hitab_client.errors import SwarmError
from hitab_client.ros_link import RosLink
from hitab_client.swarm_client import SwarmClient
from hitab_core.domain import Domain, load_domain
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_ros import qos

EXAMPLE = Path(__file__).parents[1] / "examples/diff_drive"
NAME = "diff_drive.domain:DOMAIN"
ROBOT = "robot_1"
BROKEN = """
from dataclasses import replace
from diff_drive import domain

def broken(body, *targets):
    return 1 / 0

FEATURES = {**domain.DOMAIN.features, "RangeAhead": replace(
    domain.DOMAIN.features["RangeAhead"], read=broken)}
DOMAIN = replace(domain.DOMAIN, features=FEATURES)
"""
HULL = 0.2  # m
SECONDS = 60.0


@dataclass
class Desk:
    """A simulated robot and its agent, as a demonstrator sees them."""

    link: RosLink
    agents: SwarmClient
    processes: dict[str, subprocess.Popen[bytes]]
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
    def free_ahead(self) -> float:
        """How far it is to what is straight ahead, m."""
        return math.nan if self.scan is None else self.scan.ranges[len(self.scan.ranges) // 2]

    def until(self, condition: Callable[[], Any]) -> None:
        assert self.link.spin_until(condition, SECONDS), "it did not happen in time"

    def await_value(self, feature: str) -> None:
        """Wait until the agent has heard the sensor that a feature is read from."""
        deadline = time.monotonic() + SECONDS
        while math.isnan(self._value(feature)):
            assert time.monotonic() < deadline, f"{feature} has no value"
            self.link.spin_until(lambda: False, 0.05)

    def _value(self, feature: str) -> float:
        answer = self.agents.ask(ROBOT, ReadFeatures, "read_features", also=[feature])
        return float(answer.values[answer.features.index(feature)])

    def told_to_stand_still(self) -> bool:
        """Whether the last thing that the robot was told is to stand still."""
        last = self.velocities[-1]
        return last.linear.x == 0.0 and last.angular.z == 0.0

    def end(self, name: str) -> None:
        process = self.processes[name]
        process.send_signal(signal.SIGTERM)
        assert process.wait(SECONDS) in (0, -signal.SIGTERM)


@pytest.fixture
def desk(home: Path, tmp_path: Path, request: pytest.FixtureRequest) -> Iterator[Desk]:
    """The simulated robot and its agent, each a process of its own."""
    (tmp_path / "broken.py").write_text(BROKEN)
    paths = [str(EXAMPLE), str(tmp_path), os.environ.get("PYTHONPATH", "")]
    with ExitStack() as stack:
        domain_id = stack.enter_context(reserved())
        link = stack.enter_context(RosLink(domain_id))
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "PYTHONPATH": os.pathsep.join(paths),
        }

        def start(module: str, **parameters: str) -> subprocess.Popen[bytes]:
            command = [sys.executable, "-m", module, "--ros-args", "-r", f"__ns:=/{ROBOT}"]
            for name, value in parameters.items():
                command += ["-p", f"{name}:={value}"]
            process = subprocess.Popen(command, env=environment)
            stack.callback(process.wait)
            stack.callback(process.kill)
            return process

        domain = getattr(request, "param", NAME)
        processes = {
            "robot": start("diff_drive.simulated_robot"),
            "agent": start("hitab_agent.agent_main", domain=domain, state_dir=str(tmp_path)),
        }
        desk = Desk(link, SwarmClient(link, [ROBOT]), processes)
        desk.watch()
        desk.agents.await_agent(ROBOT, SECONDS)
        desk.until(lambda: desk.odometry and desk.scan and desk.velocities)
        yield desk


def obeys(desk: Desk, behavior: str) -> bool:
    """Whether a command is taken: it is refused until the agent has heard of all its sensors."""
    try:
        desk.agents.command(ROBOT, behavior)
    except SwarmError:
        return False
    return True


def teach_to_wander(desk: Desk, near: float = 1.0, free: float = 1.8) -> None:
    """Demonstrate once round: ahead until something is near, left until the way is free."""
    desk.agents.begin(ROBOT, "Wander", features=["RangeAhead"], states=["Forward", "TurnLeft"])
    desk.until(lambda: obeys(desk, "Forward"))
    desk.until(lambda: desk.free_ahead < near)
    desk.agents.command(ROBOT, "TurnLeft")
    desk.until(lambda: desk.free_ahead > free)
    desk.agents.command(ROBOT, "Forward")


def test_a_trained_robot_wanders_about_and_bumps_into_nothing(desk, tmp_path):
    teach_to_wander(desk)
    assert desk.agents.set_mode(ROBOT, "testing").success
    desk.changes.clear()
    desk.until(lambda: desk.changes.count(("TurnLeft", "Forward")) >= 2)
    assert desk.changes[0] == ("Forward", "TurnLeft")
    assert desk.nearest > HULL
    assert desk.agents.statuses[ROBOT].last_error == ""

    saved = desk.agents.save(ROBOT, description="Drive about, turning left before what is near.")
    library = BehaviorLibrary(Path(saved.path).parent, load_domain_of_example())
    wander = library.load()["Wander"]
    assert wander.labels == ("Forward", "TurnLeft")
    assert len(wander.examples) == 6
    # What was tested goes on.
    desk.changes.clear()
    desk.until(lambda: len(desk.changes) > 0)
    desk.agents.perform(ROBOT, "")
    desk.until(desk.told_to_stand_still)


def test_the_robot_stands_still_when_its_agent_is_told_to_end(desk):
    desk.agents.perform(ROBOT, "Forward")
    desk.until(lambda: not desk.told_to_stand_still())
    desk.end("agent")
    desk.until(desk.told_to_stand_still)


def test_a_silent_sensor_is_told_and_the_robot_stands_still(desk):
    teach_to_wander(desk, near=2.3, free=1.0)
    desk.agents.set_mode(ROBOT, "testing")
    desk.end("robot")
    desk.until(lambda: desk.agents.statuses[ROBOT].last_error)
    assert 'feature "RangeAhead" has no value' in desk.agents.statuses[ROBOT].last_error
    desk.until(desk.told_to_stand_still)


@pytest.mark.parametrize("desk", ["broken:DOMAIN"], indirect=True)
def test_a_mistake_in_a_domain_is_told_by_file_and_line_and_the_agent_lives_on(desk):
    desk.agents.begin(ROBOT, "Wander", features=["RangeAhead"])
    with pytest.raises(SwarmError, match=r"ZeroDivisionError in broken\.py:6: division by zero"):
        desk.agents.command(ROBOT, "Forward")
    desk.agents.begin(ROBOT, "Wander", features=["Bumped"])
    desk.await_value("Bumped")
    assert desk.agents.command(ROBOT, "Stop").examples == 2


def load_domain_of_example() -> Domain:
    sys.path.insert(0, str(EXAMPLE))
    try:
        return load_domain(NAME)
    finally:
        sys.path.remove(str(EXAMPLE))


def test_where_things_are_is_told_relative_to_the_robot():
    domain = load_domain_of_example()
    body = domain.body(ROBOT)
    body.sense([1.5, 0.25, math.pi / 2, 1.0, 0.5, -math.pi / 2], [])
    assert domain.targets["nearest_obstacle"].resolve(body) == pytest.approx((2.0, 0.25))

    def read(feature: str, *targets: str) -> float:
        points = [domain.targets[target].resolve(body) for target in targets]
        return domain.features[feature].read(body, *points)

    assert read("DistanceTo", "goal") == pytest.approx(1.0)
    assert abs(read("HeadingTo", "goal")) == pytest.approx(math.pi)
    assert read("HeadingTo", "nearest_obstacle") == pytest.approx(-math.pi / 2)
    assert read("Bumped") == 0.0
    body.sense([1.5, 0.25, 0.0, 1.0, 0.22, 0.0], [])
    assert read("Bumped") == 1.0
    body.sense([1.5, 0.25, 0.0, *[math.nan] * 3], [])
    assert math.isnan(read("Bumped"))
