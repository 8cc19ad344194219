"""Robots, a map and scanners are related by tf, where that is installed.

Its messages come with ROS 2 only, so that here a node that is none hands over what would come.
"""

import math
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Quaternion, TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.serialization import serialize_message
from sensor_msgs.msg import LaserScan

from hitab_studio.robots import robot_watch
from hitab_studio.robots.robot_watch import RobotWatch
from hitab_studio.robots.state import Robots
from hitab_studio.robots.topics import MAP, ODOMETRY, SCAN, Options


class Node:
    """Has the graph of some robots, and takes subscriptions.

    Attributes:
        takes: what is called with the messages of topics.
    """

    def __init__(self, topics: dict[str, dict[str, str]], others: dict[str, str]) -> None:
        self.takes: dict[str, Callable[[Any], None]] = {}
        self._agents = topics
        self._others = others

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [("agent", f"/{agent}") for agent in self._agents]

    def get_subscriber_names_and_types_by_node(
        self, name: str, namespace: str
    ) -> list[tuple[str, list[str]]]:
        return [(topic, [kind]) for topic, kind in self._agents[namespace[1:]].items()]

    def get_topic_names_and_types(self) -> list[tuple[str, list[str]]]:
        return [(topic, [kind]) for topic, kind in self._others.items()]

    def get_publishers_info_by_topic(self, topic: str) -> list[Any]:
        return []

    def count_publishers(self, topic: str) -> int:
        return 1

    def create_subscription(
        self, kind: Any, topic: str, take: Callable[[Any], None], quality: Any, **options: Any
    ) -> str:
        assert options["temporary"]
        self.takes[topic] = take
        return topic

    def destroy_subscription(self, topic: str) -> None:
        del self.takes[topic]


class Link:
    def __init__(self, node: Node) -> None:
        self.node = node

    def subscribe(
        self, kind: Any, topic: str, take: Any, quality: Any, *, temporary: bool = False
    ) -> str:
        return self.node.create_subscription(kind, topic, take, quality, temporary=temporary)


@pytest.fixture(autouse=True)
def tf2_msgs(monkeypatch):
    """Have tf installed, and let each look see what has just come."""
    monkeypatch.setitem(sys.modules, "tf2_msgs", SimpleNamespace())
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", SimpleNamespace(TFMessage=object))
    monkeypatch.setattr(robot_watch, "LOOK_SECONDS", 0.0)


def way(above: str, below: str, x: float, y: float, yaw: float) -> Any:
    made = TransformStamped(child_frame_id=below)
    made.header.frame_id = above
    made.transform.translation.x, made.transform.translation.y = x, y
    made.transform.rotation = Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))
    return SimpleNamespace(transforms=[made])


def odometry(frame: str, x: float) -> bytes:
    message = Odometry(child_frame_id="base_link")
    message.header.frame_id = frame
    message.pose.pose.position.x = x
    return bytes(serialize_message(message))


def scan(frame: str, away: float) -> bytes:
    message = LaserScan(range_max=9.0, ranges=[away])
    message.header.frame_id = frame
    return bytes(serialize_message(message))


class Watched:
    """A watch of robots, which are looked at as pages do."""

    def __init__(self, agents: dict[str, dict[str, str]], others: dict[str, str]) -> None:
        self.node = Node(agents, others)
        self.refused: list[str] = []
        link: Any = Link(self.node)
        self.watch = RobotWatch(link, Options(), self.refused.append)
        self.watch.find(agents, "")
        self.look()

    def look(self, *, viewed: bool = True) -> Robots:
        return self.watch.look(viewed=viewed, cameras=(), map_=True)

    def places(self) -> dict[str, list[float]]:
        scene = self.look().scene
        assert scene is not None
        rows = scene.places[:, :3].round(6).tolist()
        return dict(zip(scene.names, rows, strict=True))


def test_robots_stand_in_the_map_where_tf_says_that_their_odometries_began():
    watched = Watched(
        {"a": {"/a/odom": ODOMETRY, "/a/scan": SCAN}, "b": {"/b/odom": ODOMETRY}}, {"/map": MAP}
    )
    takes = watched.node.takes
    assert {"/tf", "/tf_static", "/a/odom", "/a/scan", "/b/odom", "/map"} <= takes.keys()
    takes["/a/odom"](odometry("a/odom", 1.0))
    takes["/b/odom"](odometry("b/odom", 0.0))
    takes["/a/scan"](scan("a/laser", 2.0))
    assert watched.places()["a"] == [1.0, 0.0, 0.0], "nobody says otherwise"
    notes = watched.look().of("b").notes
    assert "Nobody says by tf where b/odom lies in a/odom" in notes[0]
    assert "where a/laser sits on the robot" in watched.look().of("a").notes[0]
    takes["/tf_static"](way("base_link", "a/laser", 0.5, 0.0, math.pi / 2))
    takes["/tf"](way("map", "a/odom", 10.0, 0.0, math.pi / 2))
    takes["/tf"](way("map", "b/odom", 0.0, -5.0, 0.0))
    there = watched.places()
    assert there["a"] == pytest.approx([10.0, 1.0, math.pi / 2])
    assert there["b"] == pytest.approx([0.0, -5.0, 0.0])
    known = watched.look()
    assert not known.of("a").notes + known.of("b").notes
    # Half a meter ahead of the robot, which faces y, the scanner faces left: that is -x.
    points = np.frombuffer(known.scans[16:32][:8], "<f4")
    assert points == pytest.approx([8.0, 1.5])
    grid = OccupancyGrid(data=[0])
    grid.header.frame_id = "moon"
    grid.info.width = grid.info.height = 1
    grid.info.resolution = 1.0
    takes["/map"](bytes(serialize_message(grid)))
    assert watched.look().map.grid
    assert "a/odom lies in moon" in watched.look().of("a").notes[0]
    assert watched.refused == []


def test_without_odometry_tf_alone_places_a_robot():
    watched = Watched({"burger": {"/scan": SCAN}}, {})
    assert watched.look().scene is None
    watched.node.takes["/tf"](way("map", "odom", 1.0, 0.0, 0.0))
    watched.node.takes["/tf"](way("odom", "base_footprint", 1.0, 0.5, 2.0))
    assert watched.places() == {"burger": pytest.approx([2.0, 0.5, 2.0])}
    watched.node.takes["/scan"](scan("laser", 2.0))
    watched.node.takes["/tf"](way("base_footprint", "laser", 0.0, 0.0, -2.0))
    points = np.frombuffer(watched.look().scans[16:], "<f4")
    assert points == pytest.approx([4.0, 0.5], abs=1e-6)


def test_nothing_is_listened_to_without_a_page():
    watched = Watched({"a": {"/a/odom": ODOMETRY}}, {"/map": MAP})
    watched.look(viewed=False)
    assert watched.node.takes == {}
    watched.look()
    assert "/tf" in watched.node.takes
