"""docs/turtlebot.md: a robot with the topics of a TurtleBot is trained by the page's commands."""

import math
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from geometry_msgs.msg import TwistStamped
from mentions import ROOT
from pages import Reader, steps_of
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from hitab_client import RosLink, domain_ids
from hitab_client.runs.run_folder import running_swarms

EXAMPLE = ROOT / "examples" / "turtlebot"
PAGE = "docs/turtlebot.md"
SECONDS = 100.0
HALF = math.radians(30.0)  # of the sector ahead


def installed(folder: Path) -> list[str]:
    """Return the paths on which both examples are as if pip had installed them."""
    metadata = folder / "turtlebot_example-0.1.0.dist-info"
    metadata.mkdir()
    (metadata / "METADATA").write_text("Name: turtlebot_example\nVersion: 0.1.0\n")
    (metadata / "entry_points.txt").write_text(
        "[hitab.domains]\nturtlebot = turtlebot_example.domain:DOMAIN\n"
    )
    return list(map(str, (folder, EXAMPLE, ROOT / "examples/diff_drive")))


@pytest.fixture
def room(home: Path, hitab, tmp_path: Path, monkeypatch) -> Iterator[RosLink]:
    """Have a robot with a TurtleBot's topics in a room; yield a link to it."""
    paths = installed(tmp_path)
    for path in paths:  # for commands that are forks of this process
        monkeypatch.syspath_prepend(path)
    paths.append(os.environ.get("PYTHONPATH", ""))
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(paths))
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    command = [sys.executable, "-m", "diff_drive.simulated_robot", "--ros-args"]
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        robot = subprocess.Popen([*command, "-p", "enable_stamped_cmd_vel:=true"])
        with RosLink(number) as link:
            yield link
        for _, record in list(running_swarms()):
            hitab("down", record.swarm)
        robot.kill()
        robot.wait()


@pytest.mark.long
def test_the_commands_of_the_page_train_a_robot_to_wander(room, tmp_path):
    scans: list[LaserScan] = []
    driven: list[TwistStamped] = []
    room.subscribe(LaserScan, "/scan", scans.append, qos_profile_sensor_data)
    room.subscribe(TwistStamped, "/cmd_vel", driven.append, 10)

    def ahead() -> float:
        scan = scans[-1]
        angles = (scan.angle_min + i * scan.angle_increment for i in range(len(scan.ranges)))
        return min(r for a, r in zip(angles, scan.ranges, strict=True) if abs(a) <= HALF)

    assert room.spin_until(lambda: scans, SECONDS)
    (tmp_path / "checkout").mkdir()
    reader = Reader(tmp_path / "checkout", {**os.environ, "COLUMNS": "80"})
    steps = steps_of(PAGE)
    first = next(i for i, step in enumerate(steps) if step.command.startswith("hitab up"))
    awaited = {
        ("hitab demonstrate burger TurnLeft", "hitab demonstrate burger Forward"): lambda: (
            ahead() < 0.8
        ),
        ("hitab demonstrate burger Forward", "hitab demonstrate burger TurnLeft"): lambda: (
            ahead() > 1.2
        ),
        ("hitab down", "hitab status"): lambda: (
            {m.twist.angular.z > 0 for m in driven} == {True, False}
        ),
    }
    before = ""
    for step in steps[first:]:
        if condition := awaited.get((step.command, before)):
            driven.clear()
            assert room.spin_until(condition, SECONDS), f"{step}: {ahead()} m ahead"
        assert not (complaint := reader.type(step)), complaint
        before = step.command
    assert steps[-1].command == "hitab down"
