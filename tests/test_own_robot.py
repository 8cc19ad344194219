"""A robot of one's own, examples/diff_drive: trained by topics, and safe when something fails."""

import math
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import psutil
import pytest
from arming import arm
from geometry_msgs.msg import Twist
from hitab_msgs.msg import AgentStatus, TransitionEvent
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
from hitab_robots.velocity_relay import SILENT_S
from hitab_ros import qos
from hitab_ros.stamps import seconds_of

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
    run: Callable[..., subprocess.CompletedProcess[str]]
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

    def until_later(self, seconds: float) -> None:
        """Wait until the robot has lived on for so long."""
        assert self.odometry is not None
        after = seconds_of(self.odometry.header.stamp) + seconds
        self.until(lambda: seconds_of(self.odometry.header.stamp) > after)

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
        return next(r.value for r in answer.readings if r.feature == feature)

    def told_to_stand_still(self) -> bool:
        """Whether the last thing that the robot was told is to stand still."""
        return not self.velocities or is_still(self.velocities[-1])

    def has_fault(self, text: str) -> bool:
        return any(text in fault for fault in self.agents.statuses[ROBOT].faults)

    def arm(self) -> None:
        """Let the robot act, as soon as nothing speaks against it."""
        arm(self.link, ROBOT)

    def stays_where_it_is(self) -> bool:
        """Whether the robot stands still for a while."""
        self.velocities.clear()
        self.link.spin_until(lambda: False, 1.5)
        return all(map(is_still, self.velocities))

    def end(self, name: str) -> None:
        process = self.processes[name]
        process.send_signal(signal.SIGTERM)
        assert process.wait(SECONDS) in (0, -signal.SIGTERM)


def is_still(velocity: Twist) -> bool:
    return velocity.linear.x == 0.0 and velocity.angular.z == 0.0


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

        def run(module: str, *arguments: str) -> subprocess.CompletedProcess[str]:
            return subprocess.run(
                [sys.executable, "-m", module, *arguments],
                env=environment,
                capture_output=True,
                text=True,
                timeout=SECONDS,
                check=False,
            )

        desk = Desk(link, SwarmClient(link, [ROBOT]), processes, run)
        desk.watch()
        desk.agents.await_agent(ROBOT, SECONDS)
        desk.until(lambda: desk.odometry and desk.scan)
        desk.arm()
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


def test_a_silent_sensor_is_told_and_the_robot_stands_still(desk):
    teach_to_wander(desk, near=2.3, free=1.0)
    desk.agents.set_mode(ROBOT, "testing")
    desk.end("robot")
    desk.until(lambda: desk.has_fault('feature "RangeAhead" has no value'))
    desk.until(lambda: desk.has_fault(f"sensor scan, /{ROBOT}/scan: nobody publishes it"))
    desk.until(desk.told_to_stand_still)


def test_in_training_too_a_silent_sensor_stops_the_robot_until_the_next_command(desk):
    robot, no_value = desk.processes["robot"], 'feature "RangeAhead" has no value'

    def status() -> AgentStatus:
        return desk.agents.statuses[ROBOT]

    desk.agents.begin(ROBOT, "Turn", features=["RangeAhead"])
    for commanded_to_stop in (True, False):
        desk.until(lambda: obeys(desk, "TurnLeft"))
        desk.until(lambda: not desk.told_to_stand_still())
        robot.send_signal(signal.SIGSTOP)  # all of its sensors fall silent
        desk.until(lambda: desk.has_fault(no_value))
        desk.until(desk.told_to_stand_still)
        assert list(status().active_path) == ["Start"]
        with pytest.raises(SwarmError, match=no_value):
            desk.agents.command(ROBOT, "TurnRight")
        if commanded_to_stop:
            said = desk.run("hitab_bringup.main", "demonstrate", ROBOT, "Stop").stdout
            why = f"{ROBOT} stands still, but Stop was not recorded: {no_value}"
            assert f"{ROBOT} performs Stop; Turn has 2 examples (1 default); {why}" in said
            desk.until(lambda: list(status().active_path) == ["Stop"])
        robot.send_signal(signal.SIGCONT)
        desk.until(lambda: desk.has_fault("that is over"))
        desk.arm()
        desk.velocities.clear()
        desk.until_later(2.0)
        assert all(map(is_still, desk.velocities))
        assert status().note.startswith("stands still")
    desk.agents.command(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    assert not status().note


def test_the_robot_stands_still_when_its_agent_is_killed(desk):
    desk.agents.perform(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    desk.processes["agent"].kill()
    desk.until(desk.told_to_stand_still)
    # Its relay ends too, and sends nothing but zeros until then.
    before = len(desk.velocities)
    relay = f"/{ROBOT}/cmd_vel"
    desk.until(lambda: desk.link.node.count_publishers(relay) == 0)
    assert all(map(is_still, desk.velocities[before:]))


def test_the_emergency_stop_holds_the_robot_until_it_is_released_and_re_armed(desk):
    def hitab(*arguments: str, status: int = 0) -> str:
        done = desk.run("hitab_bringup.main", *arguments)
        assert done.returncode == status, done.stderr
        return done.stdout + done.stderr

    desk.agents.perform(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    assert f"stand still: {ROBOT}\n" in hitab("stop", "--reason", "a dog")
    desk.link.spin_until(lambda: False, 0.1)
    assert desk.told_to_stand_still()
    desk.until(lambda: desk.has_fault("a dog"))
    hitab("train", ROBOT, "Held", "--state", "TurnLeft")
    for verb in (("demonstrate", ROBOT, "TurnLeft"), ("test", ROBOT)):
        assert "but: stopped: emergency stop by" in hitab(*verb), verb
    hitab("discard", ROBOT)
    assert "but: stopped: emergency stop by" in hitab("perform", ROBOT, "TurnLeft")
    refused = " ".join(hitab("arm", ROBOT, status=1).split())
    assert f"{ROBOT} may not act again: emergency stop by" in refused
    assert desk.stays_where_it_is()
    assert f"released: {ROBOT}; robots wait for `hitab arm`" in hitab("go")
    assert desk.stays_where_it_is()
    assert f"{ROBOT}: stopped: emergency stop by" in hitab("arm")
    assert hitab("arm", "--all") == f"{ROBOT} may act\n"
    desk.until(lambda: not desk.told_to_stand_still())
    desk.until(lambda: not desk.has_fault("stopped"))


def test_a_relay_that_hangs_is_replaced_and_the_robot_waits(desk):
    desk.agents.perform(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    before = psutil.Process(desk.processes["agent"].pid).children()[0]
    before.suspend()
    desk.until(lambda: not before.is_running())
    desk.until(desk.told_to_stand_still)
    desk.until(lambda: desk.has_fault("that is over, and `hitab arm"))
    assert desk.stays_where_it_is()
    desk.arm()
    desk.until(lambda: not desk.told_to_stand_still())


@pytest.mark.parametrize("lossy", [10], indirect=True)
def test_lost_datagrams_neither_stop_the_robot_nor_replace_its_relay(lossy, desk):
    """What came after a lost heartbeat was withheld until that was sent again."""
    desk.agents.perform(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    relay = psutil.Process(desk.processes["agent"].pid).children()[0]
    desk.velocities.clear()
    desk.until_later(15.0)
    assert relay.is_running()
    assert not any(map(is_still, desk.velocities))


def test_an_agent_that_hung_goes_on_only_once_re_armed(desk):
    desk.agents.perform(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    agent = desk.processes["agent"]
    agent.send_signal(signal.SIGSTOP)
    desk.until(desk.told_to_stand_still)
    desk.link.spin_until(lambda: False, 1.5 * SILENT_S)
    agent.send_signal(signal.SIGCONT)
    desk.until(lambda: desk.has_fault("gives no sign of life; that is over"))
    assert desk.stays_where_it_is()
    desk.arm()
    desk.until(lambda: not desk.told_to_stand_still())


def test_what_stands_for_nav2_drives_through_the_relay_as_the_page_says(desk):
    root = EXAMPLE.parents[1]
    page = (root / "docs/robots.md").read_text(encoding="utf-8")
    (command,) = re.findall(r"^    scripts/python (examples/nav2/.*)", page, re.MULTILINE)
    environment = {**os.environ, "ROS_DOMAIN_ID": str(desk.link.node.context.get_domain_id())}
    arguments = [sys.executable, *command.split()]
    with subprocess.Popen(arguments, cwd=root, env=environment) as controller:
        try:
            desk.until(lambda: desk.velocities and desk.velocities[-1].linear.x == 0.2)
            desk.run("hitab_bringup.main", "stop")
            desk.until(desk.told_to_stand_still)
            desk.velocities.clear()
            desk.until(lambda: len(desk.velocities) > 10)
            assert all(map(is_still, desk.velocities))
            assert not desk.has_fault("past the velocity_relay")
        finally:
            controller.kill()


def test_whoever_drives_a_robot_that_performs_nothing_is_not_disturbed(desk):
    desk.agents.perform(ROBOT, "TurnLeft")
    desk.until(lambda: not desk.told_to_stand_still())
    desk.agents.perform(ROBOT, "")
    desk.until(desk.told_to_stand_still)
    quiet = 0.0

    def drives() -> bool:
        nonlocal quiet
        if desk.velocities:
            desk.velocities.clear()
            quiet = time.monotonic()
        return time.monotonic() - quiet > 1.0

    desk.until(drives)


@pytest.mark.parametrize("desk", ["broken:DOMAIN"], indirect=True)
def test_a_mistake_in_a_domain_is_told_by_file_and_line_and_the_agent_lives_on(desk):
    desk.agents.begin(ROBOT, "Wander", features=["Bumped"])
    desk.await_value("Bumped")
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


def test_the_commands_of_the_page_make_a_copy_under_another_name(tmp_path):
    page = (EXAMPLE.parents[1] / "docs/your-own-robot.md").read_text(encoding="utf-8")
    section = page.partition("## A copy of your own\n")[2].partition("\n## ")[0]
    commands = re.findall(r"^    (.*)", section, re.MULTILINE)
    assert len(commands) == 7
    assert commands.pop().startswith("pip install ")  # it would change what all tests run in
    checkout, copy = tmp_path / "checkout", tmp_path / "my_robot"
    shutil.copytree(EXAMPLE, checkout / "examples/diff_drive")
    (checkout / "examples/diff_drive/diff_drive.egg-info").mkdir(exist_ok=True)
    environment = {**os.environ, "HOME": str(tmp_path)}
    script = "\n".join(["set -e", *commands])
    subprocess.run(["bash", "-c", script], cwd=checkout, env=environment, check=True)
    left = [path for path in copy.rglob("*") if "diff_drive" in path.name]
    assert not [path for path in left if path.suffix != ".pyc"]
    texts = [
        path.read_text() for path in copy.rglob("*") if path.suffix in (".py", ".xml", ".cfg")
    ]
    assert not [text for text in texts if "diff_drive" in text]
    loads = "from my_robot.domain import DOMAIN; print(DOMAIN.name)"
    done = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path[:0] = ['{copy}']; {loads}"],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "my_robot\n"
