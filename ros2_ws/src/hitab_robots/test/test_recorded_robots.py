"""What a person did with a robot is labeled from a recording, which has the agent's percepts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from geometry_msgs.msg import Twist
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from hitab_agent import AgentNode
from hitab_client import RosLink
from hitab_client.recording import RecordedMessages, Recorder, driving_of
from hitab_core import Domain
from hitab_core.labeling import Strip
from hitab_robots import Robot, Scan, Sector, motion, nearest_range
from hitab_ros.messages.stamps import as_time
from hitab_ros.testing import context_of_its_own, spin_until

DOMAIN = Domain.of(
    "recorded_robot",
    "1",
    Robot((Scan(sectors=(Sector("ahead", width=0.2),)),)),
    behaviors=(motion("Forward", ahead=0.5), motion("Turn", turn=1.0)),
    features=(nearest_range("RangeAhead", "scan.ahead"),),
    link="hitab_robots:RobotLink",
)


class Stage:
    """A robot's agent, its scanner, a person who drives, and a recorder."""

    def __init__(self, context: Any, link: RosLink, folder: Path) -> None:
        settings = {
            "domain": "it",
            "state_dir": str(folder),
            "relay": False,
            "rate": 50.0,
            "scan.patience": 60.0,  # the scanner is as late as this process, but never silent
        }
        self.node = AgentNode(
            context=context,
            namespace="/robot_1",
            parameter_overrides=[Parameter(k, value=v) for k, v in settings.items()],
        )
        self.executor = EventsExecutor(context=context)
        self.executor.add_node(self.node)
        self.node.join()
        self.link = link
        also = ["/robot_1/scan", "/robot_1/cmd_vel"]
        self.recorder = Recorder(link, folder / "bag.mcap", also=also)
        self.scans = link.node.create_publisher(
            LaserScan, "/robot_1/scan", qos_profile_sensor_data
        )
        self.drive = link.node.create_publisher(Twist, "/robot_1/cmd_vel", 10)
        self.velocity: Twist | None = None
        self.range = 3.0

    def each(self) -> None:
        self.range -= 0.001
        message = LaserScan(
            angle_increment=1.0, range_min=0.1, range_max=9.0, ranges=[self.range, self.range]
        )
        message.header.stamp = as_time(self.link.node.get_clock().now().nanoseconds)
        self.scans.publish(message)
        if self.velocity is not None:
            self.drive.publish(self.velocity)
        self.recorder.look()
        self.link.spin(0.0)

    def until(self, condition: Any) -> None:
        spin_until(self.executor, condition, self.each)

    def cycles(self, number: int) -> None:
        end = self.node.agent.cycle + number
        self.until(lambda: self.node.agent.cycle >= end)


def test_a_driven_robot_is_labeled_from_its_recorded_percepts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hitab_agent.host_resources.load_domain", lambda name: DOMAIN)
    with context_of_its_own() as context, RosLink(context.get_domain_id()) as link:
        stage = Stage(context, link, tmp_path)
        stage.until(lambda: stage.recorder.perceiving == ["/robot_1"])
        stage.until(lambda: not stage.recorder.missing)
        stage.velocity = Twist()
        stage.velocity.linear.x = 0.5
        stage.cycles(20)
        stage.velocity = Twist()
        stage.velocity.angular.z = 1.0
        stage.cycles(20)
        stage.recorder.close()
        stage.executor.remove_node(stage.node)
        stage.node.destroy_node()
        stage.executor.shutdown()

    recorded = {message.topic for message in RecordedMessages(tmp_path / "bag.mcap")}
    assert "/robot_1/scan" in recorded
    driven = driving_of(tmp_path / "bag.mcap", "robot_1")
    cycles = [moment.cycle for moment in driven.moments]
    assert cycles == list(range(cycles[0], cycles[0] + len(cycles)))
    moments = [moment for moment in driven.moments if moment.did is not None]
    strip = Strip(moments, DOMAIN, driven.agent, ("Forward", "Turn"), ("RangeAhead",))
    assert [span.behavior for span in strip.spans] == ["Forward", "Turn"]
