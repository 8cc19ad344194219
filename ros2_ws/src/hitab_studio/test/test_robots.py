"""Messages of robots are interpreted as in ROS, related by tf, and refused if invalid."""

import array
import io
import math
import struct
import sys
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from geometry_msgs.msg import Pose, Quaternion, TransformStamped
from hypothesis import given, settings
from hypothesis import strategies as st
from nav_msgs.msg import OccupancyGrid, Odometry
from PIL import Image
from rclpy.serialization import serialize_message
from sensor_msgs.msg import CompressedImage, LaserScan

from hitab_studio.field.scene import Palette, roster
from hitab_studio.robots import watch
from hitab_studio.robots.tf_frames import Frames
from hitab_studio.robots.topics import (
    CAMERA,
    COMMAND_TYPE,
    MAP,
    ODOM_TYPE,
    SCAN,
    Options,
    map_topic,
)
from hitab_studio.robots.watch import Robots, RobotWatch

Kinds = dict[str, str]


def turned(yaw: float) -> Quaternion:
    return Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def odometry(frame: str = "odom", x: float = 0.0, **pose: Any) -> bytes:
    message = Odometry(child_frame_id="base_link")
    message.header.frame_id = frame
    message.pose.pose.position.x, message.pose.pose.position.y = x, pose.get("y", 0.0)
    message.pose.pose.orientation = pose.get("turn", turned(pose.get("yaw", 0.0)))
    return bytes(serialize_message(message))


def scan(frame: str = "laser", **fields: Any) -> bytes:
    message = LaserScan(**{"range_max": 5.0, **fields})
    message.header.frame_id = frame
    return bytes(serialize_message(message))


def grid(width: int, height: int, cells: Sequence[int], resolution: float = 0.5) -> bytes:
    message = OccupancyGrid(data=array.array("b", cells))
    message.header.frame_id = "map"
    message.info.width, message.info.height = width, height
    message.info.resolution = resolution
    message.info.origin = Pose(orientation=turned(math.pi / 2))
    message.info.origin.position.x = 3.0
    return bytes(serialize_message(message))


def picture(data: bytes) -> bytes:
    return bytes(serialize_message(CompressedImage(format="jpeg", data=array.array("B", data))))


def image(width: int, height: int, kind: str = "JPEG") -> bytes:
    out = io.BytesIO()
    Image.new("L", (width, height)).save(out, kind)
    return out.getvalue()


def way(above: str, below: str, x: float, y: float, yaw: float) -> Any:
    """Return a `tf2_msgs/TFMessage`, which is installed with ROS 2 only."""
    made = TransformStamped(child_frame_id=below)
    made.header.frame_id = above
    made.transform.translation.x, made.transform.translation.y = x, y
    made.transform.rotation = turned(yaw)
    return SimpleNamespace(transforms=[made])


class Node:
    """A node that sees the graph of some robots, and keeps subscriptions.

    Attributes:
        takes: callbacks by topic.
    """

    def __init__(self, agents: dict[str, Kinds], others: Kinds) -> None:
        self.takes: dict[str, Callable[[Any], None]] = {}
        self.agents, self._others = agents, others

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return [("agent", f"/{agent}") for agent in self.agents]

    def get_subscriber_names_and_types_by_node(self, _: str, space: str) -> Any:
        heard = {
            **self.agents[space[1:]],
            f"{space}/command": COMMAND_TYPE,
            "/joy": "sensor_msgs/msg/Joy",
        }
        return [(topic, [kind]) for topic, kind in heard.items()]

    def get_topic_names_and_types(self) -> Any:
        there = dict(kinds for several in self.agents.values() for kinds in several.items())
        return [(topic, [kind]) for topic, kind in {**there, **self._others}.items()]

    def create_subscription(self, _: Any, topic: str, take: Any, quality: Any, **how: Any) -> str:
        assert how["temporary"]
        self.takes[topic] = take
        return topic

    def destroy_subscription(self, topic: str) -> None:
        del self.takes[topic]

    def create_client(self, *_: Any) -> Any:
        return SimpleNamespace(service_is_ready=lambda: False)

    def destroy_client(self, client: Any) -> None:
        pass


class Watched:
    """A watch of robots, called as for an open page."""

    def __init__(
        self,
        agents: dict[str, Kinds],
        others: Kinds | None = None,
        options: Options | None = None,
    ) -> None:
        self.node = Node(agents, others or {})
        link: Any = SimpleNamespace(node=self.node, subscribe=self.node.create_subscription)
        self.watch = RobotWatch(link, options or Options())
        self.watch.find(agents, "")
        self.look()

    def look(self, *, viewed: bool = True) -> Robots:
        return self.watch.look([*self.node.agents], viewed=viewed)

    def says(self, topic: str, data: Any) -> Robots:
        self.node.takes[topic](data)
        return self.look()

    def places(self) -> dict[str, list[float]]:
        scene = self.look().scene
        assert scene is not None
        return dict(zip(scene.names, scene.places[:, :3].tolist(), strict=True))

    def points(self) -> Any:
        return np.frombuffer(self.look().layers["scans"][4:], "<f4").reshape(-1, 2)


@pytest.fixture(autouse=True)
def tf2_msgs(monkeypatch):
    """Install a stand-in for tf, and let each look take the newest messages."""
    monkeypatch.setitem(sys.modules, "tf2_msgs", SimpleNamespace())
    monkeypatch.setitem(sys.modules, "tf2_msgs.msg", SimpleNamespace(TFMessage=object))
    monkeypatch.setattr(watch, "UPDATE_S", 0.0)


def one_robot() -> Watched:
    seen = Watched({"a": {"/odom": ODOM_TYPE, "/scan": SCAN}}, {"/cam": CAMERA, "/map": MAP})
    seen.says("/odom", odometry())
    return seen


def test_only_returns_of_a_scan_are_points_and_of_very_many_some_from_all_around():
    seen = one_robot()
    ranges = [1.0, math.nan, math.inf, 0.0, 0.05, 2.0, 9.0, -math.inf]
    seen.says("/scan", scan(angle_min=0.5, angle_increment=0.1, range_min=0.1, ranges=ranges))
    expected = [(r * math.cos(a), r * math.sin(a)) for r, a in ((1.0, 0.5), (2.0, 1.0))]
    assert seen.points() == pytest.approx(np.array(expected), abs=1e-6)
    seen.says("/scan", scan(angle_increment=math.tau / 50_000, ranges=[1.0] * 50_000))
    assert 1000 < len(seen.points()) <= 2000
    assert np.abs(seen.points().mean(0)).max() < 0.01


def test_a_map_lies_where_its_origin_is_and_free_cells_are_clear():
    drawn = one_robot().says("/map", grid(3, 2, [0, 100, -1, 50, 0, 0])).layers["map"]
    assert struct.unpack("<I4f", drawn[:20]) == pytest.approx((3, 3.0, 0.0, math.pi / 2, 0.5))
    opacity = np.array(Image.open(io.BytesIO(drawn[20:])).convert("RGBA"))[:, :, 3].tolist()
    half, unknown = opacity[0][0], opacity[1][2]
    assert opacity == [[half, 0, 0], [0, 255, unknown]], "the farthest row first"
    assert 0 < unknown < half < 255


def test_a_picture_is_shown_to_who_views_its_robot():
    seen = one_robot()
    assert seen.says("/cam", picture(image(640, 480))).layers["camera a"][4:] == image(640, 480)
    seen.watch.look([], viewed=True)
    assert "/cam" not in seen.node.takes


def test_what_makes_no_sense_is_refused_and_the_reason_shown_beside_its_topic():
    huge = bytearray(grid(4096, 4096, [0]))
    huge[-5:-1] = struct.pack("<I", 2**32 - 1)  # a claimed length must not allocate memory
    for topic, data, why in [
        ("/odom", odometry(x=math.nan), "no valid position"),
        ("/odom", odometry(turn=Quaternion(w=0.0)), "no valid position and orientation"),
        ("/odom", odometry()[:60], "invalid Odometry"),
        ("/scan", scan(angle_increment=math.nan), "directions of its rays"),
        ("/map", grid(2, 2, [0, 0, 0]), "announces 2 x 2 cells and has 3"),
        ("/map", grid(0, 0, []), "has 0 x 0 cells"),
        ("/map", grid(2**31, 2**31, [0]), "can be shown"),
        ("/map", grid(1, 1, [0], math.nan), "cells of nan m"),
        ("/map", bytes(huge), "invalid OccupancyGrid"),
        ("/map", bytes(17_000_000), "17 MB"),
        ("/cam", picture(b"GIF89a"), 'neither JPEG nor PNG; its format is "jpeg"'),
        ("/cam", picture(image(640, 480)[:8]), "neither"),
        ("/cam", picture(image(4, 5000, "PNG")), "4 x 5000 pixels"),
    ]:
        trouble = {s.topic: s.trouble for s in one_robot().says(topic, data).sensors["a"]}
        assert [one for one in trouble if trouble[one]] == [topic]
        assert why in trouble[topic]


@given(st.sampled_from(range(4)), st.data())
@settings(max_examples=200, deadline=None)
def test_whatever_comes_is_read_or_refused(kind, data):
    topic, sample = [
        ("/odom", odometry(x=1.0)),
        ("/scan", scan(ranges=[1.0] * 9)),
        ("/map", grid(2, 2, [0, 1, 2, 3])),
        ("/cam", picture(image(4, 4))),
    ][kind]
    broken = bytearray(sample[: data.draw(st.integers(0, len(sample)))])
    for place, value in data.draw(
        st.lists(st.tuples(st.integers(0, len(sample)), st.integers(0, 255)), max_size=4)
    ):
        if place < len(broken):
            broken[place] = value
    one_robot().says(topic, bytes(broken))


def test_frames_are_related_along_the_tree_and_nonsense_ends_nothing():
    frames = Frames()
    for sent in (("map", "odom", 10.0, 0.0, math.pi / 2), ("odom", "base_link", 1.0, 0.0, 0.0)):
        frames.take(way(*sent))
    frames.take(way("map", "dock", 0.0, 3.0, 0.0))
    there, back = frames.way("dock", "base_link"), frames.way("base_link", "/dock")
    assert there is not None
    assert back is not None
    assert there[:2, 3] == pytest.approx((10.0, -2.0))
    assert back @ there == pytest.approx(np.eye(4), abs=1e-12)
    assert frames.way("map", "moon") is None
    assert frames.way("moon", "moon") is not None, "the transform of a frame to itself is known"
    frames.take(way("b", "a", 0.0, 0.0, 0.0))
    frames.take(way("a", "b", 0.0, 0.0, 0.0))
    frames.take(way("map", "c", math.nan, 0.0, 0.0))
    assert frames.way("a", "c") is None


def test_robots_stand_in_the_map_where_tf_says_that_their_odometries_began():
    seen = Watched(
        {"a": {"/a/odom": ODOM_TYPE, "/a/scan": SCAN}, "b": {"/b/odom": ODOM_TYPE}},
        {"/map": MAP},
    )
    seen.says("/a/odom", odometry("a/odom", 1.0))
    seen.says("/b/odom", odometry("b/odom"))
    seen.says("/a/scan", scan("a/laser", range_max=9.0, ranges=[2.0]))
    assert seen.places()["a"] == [1.0, 0.0, 0.0], "drawn as if both frames were the same"
    assert "No tf from b/odom to map" in seen.look().notes["b"][0]
    assert "No tf from a/laser to the robot" in seen.look().notes["a"][1]
    seen.says("/tf_static", way("base_link", "a/laser", 0.5, 0.0, math.pi / 2))
    seen.says("/tf", way("map", "a/odom", 10.0, 0.0, math.pi / 2))
    seen.says("/tf", way("map", "b/odom", 0.0, -5.0, 0.0))
    assert seen.places()["a"] == pytest.approx([10.0, 1.0, math.pi / 2])
    assert seen.places()["b"] == pytest.approx([0.0, -5.0, 0.0])
    assert seen.look().notes == {"a": (), "b": ()}
    # Half a meter ahead of the robot, which faces y, the scanner faces left: that is -x.
    assert seen.points() == pytest.approx(np.array([[8.0, 1.5]]))


def test_without_odometry_tf_alone_places_a_robot():
    seen = Watched({"burger": {"/scan": SCAN}})
    assert seen.look().scene is None
    seen.says("/tf", way("map", "odom", 1.0, 0.0, 0.0))
    seen.says("/tf", way("odom", "burger/base_link", 1.0, 0.5, 2.0))
    assert seen.places() == {"burger": pytest.approx([2.0, 0.5, 2.0])}
    seen.says("/scan", scan(ranges=[2.0]))
    seen.says("/tf", way("burger/base_link", "laser", 0.0, 0.0, -2.0))
    assert seen.points() == pytest.approx(np.array([[4.0, 0.5]]), abs=1e-6)


def test_nothing_is_listened_to_without_a_page():
    seen = one_robot()
    seen.look(viewed=False)
    assert seen.node.takes == {}
    seen.look()
    assert {"/odom", "/scan", "/cam", "/map", "/tf", "/tf_static"} == seen.node.takes.keys()


def test_of_several_robots_each_has_the_camera_in_its_namespaces():
    agents = {
        "a": {"/red/odom": ODOM_TYPE, "/red/scan": SCAN},
        "b": {"/b/odom": ODOM_TYPE},
    }
    cameras = dict.fromkeys(("/red/right", "/red/left", "/b/left", "/b/right", "/up"), CAMERA)
    for options, expected in [
        (Options(), {"/red/left", "/b/left"}),
        (Options(cameras=("right",)), {"/red/right", "/b/right"}),
        (Options(cameras=("/red/right",)), {"/red/right"}),
    ]:
        there = Watched(agents, cameras, options).node.takes
        assert there.keys() & cameras.keys() == expected


def test_the_map_is_meant_and_no_costmap():
    kind = [MAP]
    nav2 = [(t, kind) for t in ("/local_costmap/costmap", "/map", "/global_costmap/costmap")]
    assert map_topic(nav2, Options()) == "/map"
    assert map_topic(nav2, Options(map="/global_costmap/costmap")) == "/global_costmap/costmap"
    assert map_topic([], Options()) == ""


def test_robots_are_a_field_that_holds_all_in_which_no_command_means_a_moment_of_a_world():
    seen = Watched(
        {
            "robot_10": {"/odom": ODOM_TYPE, "/scan": SCAN},
            "robot_2": {"/b/odom": ODOM_TYPE},
        }
    )
    seen.says("/odom", odometry(x=12.0))
    scene = seen.says("/b/odom", odometry(x=1.0)).scene
    assert scene is not None
    assert scene.names == ("robot_2", "robot_10")
    assert (scene.cycle, scene.center, scene.size) == (0, (5.0, 0.0), (20.0, 10.0))
    assert '"real": true' in roster(scene, Palette())
    scene = seen.says("/scan", scan(ranges=[4.5])).scene
    assert scene is not None
    assert scene.size == (25.0, 10.0)
