"""Which topics belong to which robot, by the graph of ROS.

What an agent's node subscribes to, its robot has: this holds whatever was remapped, and whichever
link it is. What no agent listens to, such as a camera, is found by its type in the namespaces of
the agent and of its odometry; of the only robot, anywhere.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hitab_core import natural

ODOMETRY = "nav_msgs/msg/Odometry"
SCAN = "sensor_msgs/msg/LaserScan"
MAP = "nav_msgs/msg/OccupancyGrid"
CAMERA = "sensor_msgs/msg/CompressedImage"
COMMAND = "hitab_msgs/msg/Command"
"""To what only agents subscribe."""

NO_SENSORS = frozenset(
    f"sensor_msgs/msg/{name}"
    for name in ("CameraInfo", "Joy", "JoyFeedback", "JoyFeedbackArray", "RegionOfInterest")
)
HEAVY = frozenset(
    f"sensor_msgs/msg/{name}" for name in ("CompressedImage", "Image", "PointCloud", "PointCloud2")
)
"""Types whose messages are not received just to know how old they are."""

ROBOTS_MAX = 50
"""Robots that are shown, by name."""

Graph = Iterable[tuple[str, Sequence[str]]]
"""Topics with their types."""


@dataclass(frozen=True)
class Options:
    """What a person has chosen, where the graph leaves a choice; "" and none: what there is.

    Attributes:
        map: topic of the map.
        cameras: topics of cameras; one without a slash at its beginning is in the namespace of
            each robot.
    """

    map: str = ""
    cameras: tuple[str, ...] = ()


@dataclass(frozen=True)
class RobotTopics:
    """The topics of one robot.

    Attributes:
        node: full name of its agent's node.
        sensors: topics of its sensors, with their types; without its camera.
        odometry, camera: topics; "": none.
        cameras: topics among which a person has to choose one.
    """

    node: str = ""
    sensors: Mapping[str, str] = field(default_factory=dict)
    odometry: str = ""
    camera: str = ""
    cameras: tuple[str, ...] = ()

    @property
    def scans(self) -> list[str]:
        """Topics of its laser scanners."""
        return [topic for topic, kind in self.sensors.items() if kind == SCAN]


def is_sensor(kind: str) -> bool:
    """Whether messages of a type come from a robot's sensor."""
    return kind == ODOMETRY or (kind.startswith("sensor_msgs/msg/") and kind not in NO_SENSORS)


def _last(topic: str) -> str:
    return topic.rsplit("/", 1)[-1]


def _of_type(graph: Graph, kind: str) -> list[str]:
    return sorted((topic for topic, kinds in graph if kind in kinds), key=natural)


def robots_topics(
    node: Any, agents: Iterable[str], prefix: str, options: Options
) -> dict[str, RobotTopics]:
    """Return the topics of each agent's robot.

    Args:
        node: by which the graph is seen.
        agents: names of agents that are there.
        prefix: namespace of the swarm.
        options: what a person has chosen.
    """
    graph = node.get_topic_names_and_types()
    there: dict[str, list[str]] = {}
    for name, namespace in node.get_node_names_and_namespaces():
        there.setdefault(namespace, []).append(name)
    agents = sorted(agents, key=natural)[:ROBOTS_MAX]
    found = {}
    for agent in agents:
        namespace = f"{prefix}/{agent}"
        own = ""
        heard: dict[str, str] = {}
        for name in there.get(namespace, ()):
            try:
                subscribed = node.get_subscriber_names_and_types_by_node(name, namespace)
            except RuntimeError:  # it has gone meanwhile
                continue
            if any(COMMAND in kinds for _, kinds in subscribed):
                own = f"{namespace}/{name}"
            heard |= {t: next(filter(is_sensor, kinds), "") for t, kinds in subscribed}
        sensors = {topic: heard[topic] for topic in sorted(heard, key=natural) if heard[topic]}
        found[agent] = _robot(own, namespace, sensors, graph, options, alone=len(agents) == 1)
    return found


def _robot(
    node: str,
    namespace: str,
    sensors: dict[str, str],
    graph: Graph,
    options: Options,
    *,
    alone: bool,
) -> RobotTopics:
    odometries = [topic for topic, kind in sensors.items() if kind == ODOMETRY]
    odometries.sort(key=lambda topic: _last(topic) != "odom")
    odometry = odometries[0] if odometries else ""
    places = tuple({f"{namespace}/", f"{odometry.rpartition('/')[0]}/"} - {"/"})

    def own(kind: str) -> list[str]:
        topics = _of_type(graph, kind)
        near = [topic for topic in topics if topic.startswith(places)]
        return near if near or not alone else topics

    cameras = [topic for topic, kind in sensors.items() if kind == CAMERA] or own(CAMERA)
    if options.cameras:
        wanted = {t if t.startswith("/") else p + t for t in options.cameras for p in places}
        cameras = [topic for topic in _of_type(graph, CAMERA) if topic in wanted]
        if not alone:  # of several, those of this one
            cameras = [topic for topic in cameras if topic.startswith(places)] or cameras
    if not any(kind == SCAN for kind in sensors.values()):
        sensors |= dict.fromkeys(own(SCAN), SCAN)
    if not odometry:
        sensors |= dict.fromkeys(own(ODOMETRY)[:1], ODOMETRY)
        odometry = next((t for t, kind in sensors.items() if kind == ODOMETRY), "")
    camera = cameras[0] if len(cameras) == 1 else ""
    sensors = {t: kind for t, kind in sensors.items() if t not in cameras}
    return RobotTopics(node, sensors, odometry, camera, tuple(cameras))


def map_topic(graph: Graph, options: Options) -> tuple[str, tuple[str, ...]]:
    """Return the topic of the map, and the topics among which a person has to choose.

    Of several, the one called ``map`` is meant: Nav2 publishes its costmaps with the same type.
    """
    topics = _of_type(graph, MAP)
    if options.map:
        return options.map, ()
    called = [topic for topic in topics if _last(topic) == "map"]
    meant = called if called else topics
    return (meant[0], ()) if len(meant) == 1 else ("", tuple(meant))
