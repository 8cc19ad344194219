"""A robot is trained from a recording: its percepts are recorded as its agent made them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hitab_msgs.msg import Command
from hitab_msgs.srv import BeginTraining, SaveBehavior, SetMode
from mcap.reader import make_reader
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

from hitab_agent import AgentNode, OfflineAgent, Retracer, Step
from hitab_client import RosLink
from hitab_client.recording import Recorder, session_of
from hitab_client.swarm_client import is_answered
from hitab_core import Domain
from hitab_robots import Robot, Scan, Sector, motion, nearest_range
from hitab_ros import qos
from hitab_ros.stamps import as_time
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
    """A robot's agent, its scanner, a person, and one who records."""

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
        self.recorder = Recorder(link, folder / "bag.mcap", also=["/robot_1/scan"])
        self.scans = link.node.create_publisher(
            LaserScan, "/robot_1/scan", qos_profile_sensor_data
        )
        self.commands = link.node.create_publisher(Command, "/robot_1/command", qos.EVENTS)
        self.range = 3.0
        self.sent = 0

    def each(self) -> None:
        self.range -= 0.001
        message = LaserScan(
            angle_increment=1.0, range_min=0.1, range_max=9.0, ranges=[self.range, self.range]
        )
        message.header.stamp = as_time(self.link.node.get_clock().now().nanoseconds)
        self.scans.publish(message)
        self.recorder.look()
        self.link.spin(0.0)

    def until(self, condition: Any) -> None:
        spin_until(self.executor, condition, self.each)

    def ask(self, kind: Any, name: str, **fields: Any) -> None:
        client = self.link.node.create_client(kind, f"/robot_1/{name}")
        self.until(client.service_is_ready)
        answer = client.call_async(kind.Request(**fields))
        self.until(answer.done)
        assert answer.result().success, answer.result().message

    def command(self, behavior: str, ago: float = 0.0) -> None:
        self.sent += 1
        command = Command(sequence=self.sent, behavior=behavior, ago=ago)
        self.until(self.commands.get_subscription_count)
        self.commands.publish(command)
        self.until(lambda: is_answered(self.node.status.message, self.sent))
        status = self.node.status.message
        assert status.last_refused_sequence != self.sent, status.last_error

    def cycles(self, number: int) -> None:
        end = self.node.agent.cycle + number
        self.until(lambda: self.node.agent.cycle >= end)


def test_a_robot_is_trained_from_a_recording_bit_for_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("hitab_agent.shared.load_domain", lambda name: DOMAIN)
    with context_of_its_own() as context, RosLink(context.get_domain_id()) as link:
        stage = Stage(context, link, tmp_path)
        stage.until(lambda: stage.recorder.sessions == ["/robot_1"])
        stage.ask(BeginTraining, "begin", automaton="Roam", features=["RangeAhead"])
        stage.cycles(3)
        stage.command("Forward")
        stage.cycles(10)
        stage.command("Turn", ago=0.1)
        stage.ask(SetMode, "set_mode", mode="testing", restart=True)
        stage.cycles(5)
        stage.ask(SaveBehavior, "save")
        stage.cycles(3)
        stage.until(lambda: stage.recorder.bag.count > 100)
        stage.recorder.close()
        learned = stage.node.agent.edition.digest
        stage.executor.remove_node(stage.node)
        stage.node.destroy_node()
        stage.executor.shutdown()

    with (tmp_path / "bag.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert "/robot_1/scan" in {channel.topic for channel in summary.channels.values()}
    session = session_of(tmp_path / "bag.mcap", "robot_1")
    again, state = tmp_path / "again", tmp_path / "state"
    with OfflineAgent("robot_1", session.domain, again, state, session.known) as offline:
        done = Retracer(offline).take(Step(*one) for one in session.sent)
        assert done.saved == ["Roam"]
        assert done.commands == 2
        assert done.compared > 3
        assert offline.agent.edition.digest == learned
