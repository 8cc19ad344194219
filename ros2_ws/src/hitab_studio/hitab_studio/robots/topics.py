"""Assigns topics to robots by the ROS graph.

The topics that an agent's node subscribes to belong to the agent's robot, with any link and any
remapping. Other topics, such as a camera's, are found by type in the namespaces of the agent and
of the odometry, or in any namespace if there is only one robot.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hitab_core import natural

ODOM_TYPE = "nav_msgs/msg/Odometry"
SCAN = "sensor_msgs/msg/LaserScan"
MAP = "nav_msgs/msg/OccupancyGrid"
CAMERA = "sensor_msgs/msg/CompressedImage"
COMMAND_TYPE = "hitab_msgs/msg/Command"
"""Message type to which only agents subscribe."""

NOT_LISTED = frozenset(
    f"sensor_msgs/msg/{name}"
    for name in ("CameraInfo", "CompressedImage", "Image", "Joy", "PointCloud", "PointCloud2")
)
"""Types that are no sensors, or too large to be received only for the age of a message."""

ROBOTS_MAX = 50
"""Maximum number of robots shown, the first by name."""

Graph = Iterable[tuple[str, Sequence[str]]]
"""Topics with their types."""


@dataclass(frozen=True)
class Options:
    """The chosen topics of robots; without a choice, the first is used.

    Attributes:
        map: topic of the map; "" without a choice.
        cameras: topics of cameras, or their last parts, such as ``front/image`` in the namespace
            of each robot; empty without a choice.
    """

    map: str = ""
    cameras: tuple[str, ...] = ()


@dataclass(frozen=True)
class RobotTopics:
    """The topics of one robot.

    Attributes:
        node: full name of the agent's node; "" if the node has ended.
        sensors: types of the sensors' topics, by topic; without the camera.
        odometry, camera: topics of the odometry and of the camera; "" if none.
    """

    node: str = ""
    sensors: Mapping[str, str] = field(default_factory=dict)
    odometry: str = ""
    camera: str = ""

    @property
    def scans(self) -> list[str]:
        """Topics of the robot's laser scanners."""
        return [topic for topic, kind in self.sensors.items() if kind == SCAN]


def is_sensor(kind: str) -> bool:
    """Whether messages of a type come from a robot's sensor."""
    return kind == ODOM_TYPE or (kind.startswith("sensor_msgs/msg/") and kind not in NOT_LISTED)


def _of_type(graph: Graph, kind: str) -> list[str]:
    return sorted((topic for topic, kinds in graph if kind in kinds), key=natural)


def robots_topics(
    node: Any, agents: Iterable[str], prefix: str, options: Options
) -> dict[str, RobotTopics]:
    """Return the topics of each agent's robot.

    Args:
        node: node whose view of the graph is used.
        agents: names of the present agents.
        prefix: namespace of the swarm.
        options: the chosen topics.
    """
    graph = node.get_topic_names_and_types()
    agents = sorted(agents, key=natural)[:ROBOTS_MAX]
    alone = len(agents) == 1
    spaces = {f"{prefix}/{agent}": agent for agent in agents}
    nodes = dict.fromkeys(agents, "")
    heard: dict[str, dict[str, str]] = {agent: {} for agent in agents}
    for name, space in node.get_node_names_and_namespaces():
        if (agent := spaces.get(space)) is None:
            continue
        try:
            subscribed = node.get_subscriber_names_and_types_by_node(name, space)
        except RuntimeError:  # the node has ended meanwhile
            continue
        if any(COMMAND_TYPE in kinds for _, kinds in subscribed):
            nodes[agent] = f"{space}/{name}"
        heard[agent] |= {t: kind for t, kinds in subscribed for kind in filter(is_sensor, kinds)}
    return {
        agent: _robot(nodes[agent], space, heard[agent], graph, options, alone=alone)
        for space, agent in spaces.items()
    }


def _robot(
    node: str,
    space: str,
    sensors: dict[str, str],
    graph: Graph,
    options: Options,
    *,
    alone: bool,
) -> RobotTopics:
    places = [f"{space}/"]

    def of(kind: str, among: Sequence[str] | None = None) -> list[str]:
        topics = _of_type(graph, kind) if among is None else among
        heard = [topic for topic in topics if sensors.get(topic) == kind]
        near = [topic for topic in topics if topic.startswith(tuple(places))]
        return list(heard or near or (topics if alone else ()))

    odometry = next(iter(sorted(of(ODOM_TYPE), key=lambda topic: not topic.endswith("/odom"))), "")
    places += [f"{odometry.rpartition('/')[0]}/"] if odometry.count("/") > 1 else []
    cameras = _of_type(graph, CAMERA)
    if options.cameras:
        cameras = [t for t in cameras if any(f"/{t}".endswith(f"/{c}") for c in options.cameras)]
    camera = next(iter(of(CAMERA, cameras)), "")
    sensors |= dict.fromkeys(of(SCAN), SCAN) | ({odometry: ODOM_TYPE} if odometry else {})
    return RobotTopics(node, sensors, odometry, camera)


def map_topic(graph: Graph, options: Options) -> str:
    """Return the topic of the map; "" if there is none.

    Of several, the one called ``map`` is preferred: Nav2 publishes costmaps with the same type.
    """
    topics = sorted(_of_type(graph, MAP), key=lambda topic: not topic.endswith("/map"))
    return options.map or next(iter(topics), "")
