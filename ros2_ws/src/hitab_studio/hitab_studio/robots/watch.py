"""Watches the robots of a swarm without a simulated world, while a page is open."""

from __future__ import annotations

import struct
import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile

from hitab_client import RosLink
from hitab_core import natural
from hitab_ros.timing import UPDATE_S
from hitab_studio.field.scene import Appearance, Scene
from hitab_studio.robots.mounts import Mounts
from hitab_studio.robots.robot_messages import SCANS, Grid, Placed
from hitab_studio.robots.tf_frames import Frames, Matrix, applied, in_plane
from hitab_studio.robots.topic_reader import TopicReader
from hitab_studio.robots.topics import (
    CAMERA,
    MAP,
    Options,
    RobotTopics,
    map_topic,
    robots_topics,
)

MAP_FRAME = "map"  # as in REP 105
TF_QUEUE = 200

RADIUS = 0.2
"""Radius with which robots are drawn, m; no message contains their size."""

STEP = 5.0
"""Step in which the ground grows, m, so that the view does not change all the time."""

GROUND_MARGIN = 2.0
"""Distance from a robot to the edge of the ground, m."""

Place = tuple[float, float, float]
"""A pose in the plane: x and y, m, and heading, rad."""


@dataclass(frozen=True)
class SensorStatus:
    """A sensor, for people: topic, type, age of the last message, and trouble if any."""

    topic: str
    kind: str
    age: str
    trouble: str = ""


@dataclass(frozen=True)
class Robots:
    """The known state of the robots at one moment.

    Attributes:
        scene: poses of the robots; None if no pose is known.
        lost: names of the robots whose odometry is silent, drawn at their last place.
        sensors: sensors of each robot, with the camera and the map, by agent.
        notes: remarks on how each robot is drawn, by agent.
        layers: binary frames drawn beside the scene: "scans", "map", and "camera robot_1" for the
            camera of each robot.
    """

    scene: Scene | None = None
    lost: frozenset[str] = frozenset()
    sensors: Mapping[str, tuple[SensorStatus, ...]] = field(
        default_factory=lambda: MappingProxyType({})
    )
    notes: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))
    layers: Mapping[str, bytes] = field(default_factory=lambda: MappingProxyType({}))


class RobotWatch:
    """Finds the robots' topics and listens to them.

    Args:
        link: link with the node to use.
        options: the chosen topics.
    """

    def __init__(self, link: RosLink, options: Options) -> None:
        self._link = link
        self._options = options
        self._topics: dict[str, RobotTopics] = {}
        self._map_topic = ""
        self._readers: dict[str, TopicReader] = {}
        self._mounts: dict[str, Mounts] = {}
        self._frames = Frames()
        self._tf: list[Any] = []
        self._next_look = 0.0
        self._known = Robots()

    def find(self, agents: Collection[str], prefix: str) -> None:
        """Find the present topics of the robots.

        A robot whose agent has ended keeps its topics, since its place is still of interest.
        """
        node = self._link.node
        for agent, topics in robots_topics(node, agents, prefix, self._options).items():
            if topics.node or agent not in self._topics:
                self._topics[agent] = topics
        self._map_topic = map_topic(node.get_topic_names_and_types(), self._options)

    def look(self, agents: Collection[str], *, viewed: bool) -> Robots:
        """Return the known state of the robots.

        Args:
            agents: the agents whose cameras are shown.
            viewed: whether a page is open; otherwise all subscriptions end.
        """
        now = time.monotonic()
        if not viewed:
            self.close()
        elif now >= self._next_look:
            self._next_look = now + UPDATE_S
            self._listen(agents)
            self._known = self._look()
        return self._known

    def close(self) -> None:
        """End all subscriptions."""
        for open_one in self._open():
            open_one.close()
        for subscription in self._tf:
            self._link.node.destroy_subscription(subscription)
        self._readers.clear()
        self._mounts.clear()
        self._tf.clear()

    def _open(self) -> list[TopicReader | Mounts]:
        return [*self._readers.values(), *self._mounts.values()]

    def _listen(self, agents: Collection[str]) -> None:
        """Subscribe to the topics that pages show, and to no others."""
        wanted = {self._map_topic: MAP}
        for agent, robot in self._topics.items():
            wanted |= robot.sensors
            if agent in agents:
                wanted[robot.camera] = CAMERA
            if agent not in self._mounts and robot.node:
                self._mounts[agent] = Mounts(self._link, robot.node, robot.scans)
        wanted.pop("", None)
        for topic in self._readers.keys() - wanted.keys():
            self._readers.pop(topic).close()
        for topic, kind in wanted.items():
            if topic not in self._readers:
                self._readers[topic] = TopicReader(self._link, topic, kind)
        self._listen_to_tf()
        for open_one in self._open():
            open_one.look()

    def _listen_to_tf(self) -> None:
        """Subscribe to tf, if its messages are installed, as with every ROS 2 distribution."""
        if self._tf:
            return
        try:
            kind = import_module("tf2_msgs.msg").TFMessage
        except ImportError:
            return
        kept = QoSProfile(depth=TF_QUEUE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        for topic, quality in (("/tf", QoSProfile(depth=TF_QUEUE)), ("/tf_static", kept)):
            take = self._frames.take
            self._tf.append(self._link.subscribe(kind, topic, take, quality, temporary=True))

    # -- known state ------------------------------------------------------------------------

    def _value(self, topic: str) -> Any:
        reader = self._readers.get(topic)
        return None if reader is None else reader.value

    def _look(self) -> Robots:
        grid: Grid | None = self._value(self._map_topic)
        fixed = grid.frame if grid is not None else MAP_FRAME
        places: dict[str, Place] = {}
        clouds: list[Matrix] = []
        lost = set()
        notes: dict[str, tuple[str, ...]] = {}
        layers = {"map": grid.drawn} if grid is not None else {}
        for agent, robot in self._topics.items():
            remarks: list[str] = []
            pose, base = self._pose(agent, fixed, remarks)
            if pose is not None:
                places[agent] = in_plane(pose)
                clouds += self._clouds(agent, pose, base, remarks)
            if robot.odometry in self._readers and self._readers[robot.odometry].is_silent:
                lost.add(agent)
            if (picture := self._value(robot.camera)) is not None:
                layers[f"camera {agent}"] = picture
            notes[agent] = tuple(remarks)
        scan = np.concatenate([np.empty((0, 2)), *clouds])
        layers["scans"] = struct.pack("<I", SCANS) + scan.astype("<f4").tobytes()
        return Robots(
            robot_scene(places, [*clouds, *([grid.corners] if grid is not None else [])]),
            frozenset(lost),
            MappingProxyType({agent: self._sensors(agent) for agent in self._topics}),
            MappingProxyType(notes),
            MappingProxyType(layers),
        )

    def _pose(self, agent: str, fixed: str, notes: list[str]) -> tuple[Matrix | None, str]:
        """Return the pose of a robot from odometry or tf, None if unknown, and its base frame."""
        placed: Placed | None = self._value(self._topics[agent].odometry)
        if placed is None:
            base = f"{agent}/base_link"
            return self._frames.way(fixed, base), base
        way = self._frames.way(fixed, placed.frame)
        if way is not None:
            return way @ placed.pose, placed.child
        if len(self._topics) > 1 or self._value(self._map_topic) is not None:
            notes.append(
                f"No tf from {placed.frame or 'the frame of the odometry'} to {fixed}: the robot "
                "is drawn as if both were the same."
            )
        return placed.pose, placed.child

    def _clouds(self, agent: str, pose: Matrix, base: str, notes: list[str]) -> list[Matrix]:
        """Return the scans of a robot, in the frame of the drawing."""
        found = []
        for topic in self._topics[agent].scans:
            reader = self._readers[topic]
            if reader.value is None or reader.is_silent:
                continue
            scan, mounts = reader.value, self._mounts.get(agent)
            mount = self._frames.way(base, scan.frame)
            if mount is None and mounts is not None:
                mount = mounts.of.get(topic)
            if mount is None:
                mount = np.eye(4)
                notes.append(
                    f"No tf from {scan.frame or 'the scanner'} to the robot: {topic} is drawn as "
                    "if the scanner were in the middle and faced ahead."
                )
            found.append(applied(pose @ mount, scan.points))
        return found

    def _sensors(self, agent: str) -> tuple[SensorStatus, ...]:
        robot = self._topics[agent]
        found = []
        for topic, kind in {**robot.sensors, robot.camera: CAMERA, self._map_topic: MAP}.items():
            reader = self._readers.get(topic)
            if reader is not None:
                age = "no message yet" if reader.age is None else f"{reader.age:.1f} s ago"
                found.append(SensorStatus(topic, kind, age, reader.trouble))
        return tuple(found)


def robot_scene(places: Mapping[str, Place], around: Collection[Matrix]) -> Scene | None:
    """Return the field with the robots; None if no robot's place is known.

    The scene has no cycles, so that commands do not refer to a moment of a world.

    Args:
        places: places of the robots, by name.
        around: further points inside the field, m, each of shape (n, 2).
    """
    if not places:
        return None
    names = sorted(places, key=natural)
    rows = np.array([(*places[name], 0.0, 0.0) for name in names], dtype=np.float64)
    rows.setflags(write=False)
    drawn = np.concatenate([rows[:, :2] - GROUND_MARGIN, rows[:, :2] + GROUND_MARGIN, *around])
    low, high = np.floor(drawn.min(0) / STEP) * STEP, np.ceil(drawn.max(0) / STEP) * STEP
    return Scene(
        size=tuple((high - low).tolist()),
        names=tuple(names),
        kinds=("robot",) * len(names),
        radii=(RADIUS,) * len(names),
        places=rows,
        looks=MappingProxyType({"robot": Appearance()}),
        center=tuple(((low + high) / 2).tolist()),
        real=True,
    )
