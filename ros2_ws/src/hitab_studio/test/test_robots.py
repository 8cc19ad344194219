"""What robots say is read as ROS reads it, and refused if it makes no sense."""

import array
import contextlib
import io
import math
import struct
from collections.abc import Callable, Sequence
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

from hitab_studio.robots import messages
from hitab_studio.robots.frames import Frames, applied, heading, in_plane
from hitab_studio.robots.messages import Refused
from hitab_studio.robots.serving import png_of
from hitab_studio.robots.showing import ground, robot_scene, scans_frame
from hitab_studio.robots.topics import Options, map_topic, robots_topics
from hitab_studio.scene import Palette, roster

Kinds = Sequence[tuple[str, list[str]]]


def reading(kind: Any, of: Callable[[Any], Any]) -> Callable[[bytes], Any]:
    return lambda data: of(messages.read(kind, data))


odometry_of = reading(Odometry, messages.odometry_of)
scan_of = reading(LaserScan, messages.scan_of)
map_of = reading(OccupancyGrid, messages.map_of)
picture_of = reading(CompressedImage, messages.picture_of)


def turned(yaw: float) -> Quaternion:
    return Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def odometry(frame: str = "odom", **pose: Any) -> bytes:
    message = Odometry(child_frame_id="base_link")
    message.header.frame_id = frame
    message.header.stamp.sec, message.header.stamp.nanosec = 7, 500_000_000
    message.pose.pose.position.x = pose.get("x", 0.0)
    message.pose.pose.position.y = pose.get("y", 0.0)
    message.pose.pose.orientation = pose.get("turn", turned(pose.get("yaw", 0.0)))
    return bytes(serialize_message(message))


def grid(width: int, height: int, cells: Sequence[int], resolution: float = 0.5) -> bytes:
    message = OccupancyGrid(data=array.array("b", cells))
    message.header.frame_id = "map"
    message.info.width, message.info.height = width, height
    message.info.resolution = resolution
    message.info.origin = Pose(orientation=turned(math.pi / 2))
    message.info.origin.position.x = 3.0
    return bytes(serialize_message(message))


def picture(data: bytes, claimed: str = "jpeg") -> bytes:
    message = CompressedImage(format=claimed, data=array.array("B", data))
    return bytes(serialize_message(message))


def image(width: int, height: int, kind: str = "JPEG") -> bytes:
    out = io.BytesIO()
    Image.new("L", (width, height)).save(out, kind)
    return out.getvalue()


# -- messages -------------------------------------------------------------------------------


def test_an_odometry_is_read_as_it_was_published():
    for frame in ["", "o", "odom", "robot_1/odom"]:
        placed = odometry_of(odometry(frame, x=1.5, y=-2.0, yaw=2.5))
        assert (placed.frame, placed.child) == (frame, "base_link")
        assert placed.pose[:2, 3].tolist() == [1.5, -2.0]
        assert heading(placed.pose) == pytest.approx(2.5)


def test_only_returns_of_a_scan_are_points():
    ranges = [1.0, math.nan, math.inf, 0.0, 0.05, 2.0, 9.0, -math.inf]
    message = LaserScan(
        angle_min=0.5, angle_increment=0.1, range_min=0.1, range_max=5.0, ranges=ranges
    )
    points = scan_of(bytes(serialize_message(message))).points
    expected = [(r * math.cos(a), r * math.sin(a)) for r, a in ((1.0, 0.5), (2.0, 1.0))]
    assert points == pytest.approx(np.array(expected), abs=1e-6)


def test_of_a_scan_with_very_many_rays_some_are_shown_from_all_around():
    message = LaserScan(
        angle_min=-math.pi, angle_increment=math.tau / 50_000, range_max=5.0, ranges=[1.0] * 50_000
    )
    points = scan_of(bytes(serialize_message(message))).points
    assert 1000 < len(points) <= 2000
    assert np.abs(points.mean(0)).max() < 0.01


def test_a_map_lies_where_its_origin_is_and_free_cells_are_clear():
    read = map_of(grid(3, 2, [0, 100, -1, 50, 0, 0]))
    assert read.cells.tolist() == [[0, 100, -1], [50, 0, 0]]
    assert read.place == pytest.approx((3.0, 0.0, math.pi / 2))
    assert read.corners()[3] == pytest.approx((2.0, 1.5)), "it is turned"
    png = png_of(read)
    opacity = np.array(Image.open(io.BytesIO(png)).convert("RGBA"))[:, :, 3].tolist()
    half, unknown = opacity[0][0], opacity[1][2]
    assert opacity == [[half, 0, 0], [0, 255, unknown]], "the farthest row first"
    assert 0 < unknown < half < 255


def test_what_makes_no_sense_is_refused():
    for read, data, why in [
        (odometry_of, odometry(x=math.nan), "nowhere"),
        (odometry_of, odometry(y=math.inf), "nowhere"),
        (odometry_of, odometry(turn=Quaternion(w=0.0)), "no quaternion"),
        (odometry_of, odometry()[:60], "no Odometry"),
        (odometry_of, b"", "no Odometry"),
        (odometry_of, odometry("x" * 300), "a frame whose name has more than 256"),
        (scan_of, bytes(serialize_message(LaserScan(angle_increment=math.nan))), "rays point"),
        (map_of, grid(2, 2, [0, 0, 0]), "says that it has 2 x 2 cells, and has 3"),
        (map_of, grid(0, 0, []), "has 0 x 0 cells"),
        (map_of, grid(2**31, 2**31, [0]), "can be shown"),
        (map_of, grid(1, 1, [0], math.nan), "cells of nan m"),
        (map_of, grid(1, 1, [0], -1.0), "cells of -1 m"),
        (picture_of, picture(b"GIF89a"), 'neither JPEG nor PNG; it calls itself "jpeg"'),
        (picture_of, picture(b""), "neither"),
        (picture_of, picture(image(640, 480)[:8]), "neither"),
        (picture_of, picture(image(5000, 4)), "5000 x 4 pixels"),
        (picture_of, picture(image(4, 5000, "PNG")), "4 x 5000 pixels"),
    ]:
        with pytest.raises(Refused, match=why):
            read(data)


def test_a_length_that_is_claimed_takes_no_memory():
    data = bytearray(grid(4096, 4096, [0]))
    data[-5:-1] = struct.pack("<I", 2**32 - 1)
    with pytest.raises(Refused, match="no OccupancyGrid"):
        map_of(bytes(data))


@given(st.sampled_from(range(4)), st.data())
@settings(max_examples=200, deadline=None)
def test_whatever_comes_is_read_or_refused(kind, data):
    scan = serialize_message(LaserScan(ranges=[1.0] * 9))
    reads: list[tuple[Callable[[bytes], Any], bytes]] = [
        (odometry_of, odometry(x=1.0)),
        (scan_of, bytes(scan)),
        (map_of, grid(2, 2, [0, 1, 2, 3])),
        (picture_of, picture(image(4, 4))),
    ]
    read, sample = reads[kind]
    broken = bytearray(sample[: data.draw(st.integers(0, len(sample)))])
    for place, value in data.draw(
        st.lists(st.tuples(st.integers(0, len(sample)), st.integers(0, 255)), max_size=4)
    ):
        if place < len(broken):
            broken[place] = value
    with contextlib.suppress(Refused):
        read(bytes(broken))


def test_a_picture_is_shown_as_what_it_is_and_not_as_what_it_claims():
    shown = picture_of(picture(image(640, 480), "png"))
    assert (shown.media_type, shown.data) == ("image/jpeg", image(640, 480))


# -- frames ---------------------------------------------------------------------------------


class Told:
    """A `tf2_msgs/TFMessage`, which is installed with ROS 2 only."""

    def __init__(self, *ways: tuple[str, str, float, float, float]) -> None:
        self.transforms = []
        for above, below, x, y, yaw in ways:
            made = TransformStamped(child_frame_id=below)
            made.header.frame_id = above
            made.transform.translation.x, made.transform.translation.y = x, y
            made.transform.rotation = turned(yaw)
            self.transforms.append(made)


def test_frames_are_related_along_the_tree_in_both_directions():
    frames = Frames()
    frames.take(
        Told(
            ("map", "odom", 10.0, 0.0, math.pi / 2),
            ("odom", "base_link", 1.0, 0.0, 0.0),
            ("base_link", "laser", 0.0, 0.5, 0.0),
            ("map", "dock", 0.0, 3.0, 0.0),
        )
    )
    way = frames.way("map", "laser")
    assert way is not None
    assert way[:2, 3] == pytest.approx((9.5, 1.0))
    back = frames.way("laser", "/map")
    assert back is not None
    assert back @ way == pytest.approx(np.eye(4), abs=1e-12)
    aside = frames.way("dock", "odom")
    assert aside is not None
    assert aside[:2, 3] == pytest.approx((10.0, -3.0))
    assert frames.way("map", "moon") is None
    same = frames.way("moon", "moon")
    assert same is not None, "a frame is where it is, whoever knows it"


def test_frames_in_a_circle_and_nonsense_end_nothing():
    frames = Frames()
    frames.take(Told(("a", "b", 0.0, 0.0, 0.0), ("b", "a", 0.0, 0.0, 0.0)))
    assert frames.way("a", "c") is None
    frames.take(Told(("map", "odom", math.nan, 0.0, 0.0)))
    assert frames.way("map", "odom") is None


@given(st.floats(-9, 9), st.floats(-9, 9), st.floats(-7, 7), st.booleans())
def test_a_scanner_turned_over_counts_clockwise(x, y, yaw, upside_down):
    ray = np.array([[2.0 * math.cos(0.3), 2.0 * math.sin(0.3)]])
    (found,) = applied(in_plane(x, y, yaw, upside_down=upside_down), ray).tolist()
    angle = yaw + (-0.3 if upside_down else 0.3)
    assert found == pytest.approx((x + 2.0 * math.cos(angle), y + 2.0 * math.sin(angle)))


# -- topics ---------------------------------------------------------------------------------


class Graph:
    """The graph as a node sees it."""

    def __init__(self, nodes: dict[tuple[str, str], Kinds], others: Kinds = ()) -> None:
        self._nodes = nodes
        self._others = others

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        return list(self._nodes)

    def get_subscriber_names_and_types_by_node(self, name: str, namespace: str) -> Kinds:
        return self._nodes[name, namespace]

    def get_topic_names_and_types(self) -> Kinds:
        there = dict(kinds for several in self._nodes.values() for kinds in several)
        return [*there.items(), *self._others]


def agent_of(name: str, odom: str, scan: str) -> dict[tuple[str, str], Kinds]:
    return {
        ("agent", f"/{name}"): [
            (f"/{name}/command", ["hitab_msgs/msg/Command"]),
            (odom, ["nav_msgs/msg/Odometry"]),
            (scan, ["sensor_msgs/msg/LaserScan"]),
            ("/joy", ["sensor_msgs/msg/Joy"]),
        ],
        ("velocity_relay", f"/{name}"): [(f"/{name}/cmd_vel_agent", ["geometry_msgs/msg/Twist"])],
    }


def cameras(*topics: str) -> list[tuple[str, list[str]]]:
    return [(topic, ["sensor_msgs/msg/CompressedImage"]) for topic in topics]


def test_a_robot_has_what_its_agent_listens_to_whatever_was_remapped():
    graph = Graph(agent_of("burger", "/odom", "/lidar/scan"), cameras("/cam/image/compressed"))
    found = robots_topics(graph, ["burger"], "", Options())["burger"]
    assert found.node == "/burger/agent"
    assert (found.odometry, found.scans) == ("/odom", ["/lidar/scan"])
    assert found.camera == "/cam/image/compressed", "of the only robot"
    assert "/joy" not in found.sensors


def test_of_several_robots_each_has_the_camera_in_its_namespaces():
    nodes = agent_of("a", "/red/odom", "/red/scan") | agent_of("b", "/b/odom", "/b/scan")
    graph = Graph(nodes, cameras("/red/image", "/b/image", "/ceiling"))
    found = robots_topics(graph, ["a", "b"], "", Options())
    assert (found["a"].camera, found["b"].camera) == ("/red/image", "/b/image")
    two = Graph(nodes, cameras("/red/left", "/red/right", "/b/left"))
    found = robots_topics(two, ["a", "b"], "", Options())
    assert (found["a"].camera, found["a"].cameras) == ("", ("/red/left", "/red/right"))
    found = robots_topics(two, ["a", "b"], "", Options(cameras=("left",)))
    assert (found["a"].camera, found["b"].camera) == ("/red/left", "/b/left")
    found = robots_topics(two, ["a", "b"], "", Options(cameras=("/red/right",)))
    assert found["a"].camera == "/red/right"


def test_the_map_is_meant_and_no_costmap():
    kind = ["nav_msgs/msg/OccupancyGrid"]
    nav2 = [(t, kind) for t in ("/map", "/local_costmap/costmap", "/global_costmap/costmap")]
    assert map_topic(nav2, Options()) == ("/map", ())
    two = [(t, kind) for t in ("/a/map", "/b/map")]
    assert map_topic(two, Options()) == ("", ("/a/map", "/b/map"))
    assert map_topic(two, Options(map="/b/map")) == ("/b/map", ())
    assert map_topic([], Options()) == ("", ())


# -- what is shown --------------------------------------------------------------------------


def test_the_ground_holds_robots_what_they_scan_and_the_map():
    one = {"a": (12.0, 0.0, 0.0)}
    assert ground(one, {}, None) == (12.5, 0.0, 5.0, 10.0)
    assert ground(one, {"a": [np.array([[20.5, 1.0]])]}, None) == (17.5, 0.0, 15.0, 10.0)
    assert ground({}, {}, np.array([[-9.0, 0.0], [1.0, 8.0]])) == (-2.5, 2.5, 15.0, 15.0)


def test_robots_are_a_field_in_which_no_command_means_a_moment_of_a_world():
    places = {"robot_10": (1.0, 2.0, 0.5), "robot_2": (3.0, 4.0, 0.0)}
    scene = robot_scene(places, (2.0, 3.0, 8.0, 8.0))
    assert scene.names == ("robot_2", "robot_10")
    assert (scene.cycle, scene.center, scene.real) == (0, (2.0, 3.0), True)
    assert '"real": true' in roster(scene, Palette())
    cloud = np.array([[1.0, 2.0]])
    data = scans_frame(scene.names, {"robot_10": [cloud, cloud], "gone": [cloud]})
    assert struct.unpack("<6I", data[:24]) == (2, 2, 0, 0, 1, 2)
    assert np.frombuffer(data[24:], "<f4").tolist() == [1.0, 2.0, 1.0, 2.0]
