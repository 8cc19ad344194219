"""Watches the robots of a swarm without a world, while a page is open; in the link's thread."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
from rclpy.qos import DurabilityPolicy, QoSProfile

from hitab_client import RosLink
from hitab_studio.robots.frames import Frames, Matrix, heading
from hitab_studio.robots.listening import Listening, SensorState
from hitab_studio.robots.messages import MAP_BYTES, Grid, map_of
from hitab_studio.robots.robot import Reading, Robot
from hitab_studio.robots.showing import Place, ground, robot_scene, scans_frame
from hitab_studio.robots.state import MapState, Robots, RobotState
from hitab_studio.robots.topics import MAP, Options, RobotTopics, map_topic, robots_topics

LOOK_SECONDS = 0.1
"""Between two looks: no page shows more."""

MAP_FRAME = "map"  # as in REP 105
TF_QUEUE = 200


class RobotWatch:
    """Finds the robots' topics and listens to them.

    Args:
        link: the node to use.
        options: what a person has chosen.
        refuse: called once for each reason why what a topic sends is not shown.
    """

    def __init__(self, link: RosLink, options: Options, refuse: Callable[[str], None]) -> None:
        self._link = link
        self._options = options
        self._refuse = refuse
        self._told: set[str] = set()
        self._topics: dict[str, RobotTopics] = {}
        self._robots: dict[str, Robot] = {}
        self._map_topic = ""
        self._map_choices: tuple[str, ...] = ()
        self._map: Reading | None = None
        self._frames = Frames()
        self._tf: list[Any] = []
        self._next_look = 0.0
        self._known = Robots()

    def find(self, agents: Collection[str], prefix: str) -> None:
        """Find the topics that there are now.

        A robot whose agent has ended has those that it had: one may look where it stands.
        """
        node = self._link.node
        found = robots_topics(node, agents, prefix, self._options)
        self._topics = {
            agent: topics if topics.node else self._topics.get(agent, topics)
            for agent, topics in found.items()
        }
        graph = node.get_topic_names_and_types()
        self._map_topic, self._map_choices = map_topic(graph, self._options)
        for agent in [a for a, r in self._robots.items() if r.topics != self._topics.get(a)]:
            self._robots.pop(agent).close()

    def look(self, *, viewed: bool, cameras: Collection[str], map_: bool) -> Robots:
        """Return what is known now.

        Args:
            viewed: whether a page is open; without one, nothing is listened to.
            cameras: agents whose cameras a page shows.
            map_: whether a page shows the map.
        """
        now = time.monotonic()
        if not viewed:
            self.close()
            return self._known
        if now < self._next_look:
            return self._known
        self._next_look = now + LOOK_SECONDS
        self._listen_to_tf()
        for agent, topics in self._topics.items():
            if agent not in self._robots:
                self._robots[agent] = Robot(self._link, topics)
            self._robots[agent].watch_camera(on=agent in cameras)
            self._robots[agent].look()
        self._look_at_map(on=map_)
        self._known = self._state(now)
        self._tell()
        return self._known

    def close(self) -> None:
        """Listen no more."""
        for robot in self._robots.values():
            robot.close()
        self._robots.clear()
        self._look_at_map(on=False)
        for subscription in self._tf:
            self._link.node.destroy_subscription(subscription)
        self._tf.clear()

    def _listen_to_tf(self) -> None:
        """Listen to tf, if its messages are installed: they come with ROS 2 only."""
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

    def _look_at_map(self, *, on: bool) -> None:
        wanted = self._map_topic if on else ""
        if self._map is not None and self._map.listening.topic != wanted:
            self._map.listening.close()
            self._map = None
        if wanted and self._map is None:
            listening = Listening(self._link, wanted, MAP, MAP_BYTES)
            self._map = Reading(listening, map_of)
        if self._map is not None:
            self._map.look()

    # -- what is known ----------------------------------------------------------------------

    def _state(self, now: float) -> Robots:
        map_state = self._map_state()
        fixed = self._fixed(map_state.grid)
        places: dict[str, Place] = {}
        points: dict[str, list[Matrix]] = {}
        states: dict[str, RobotState] = {}
        lost = set()
        alone = len(self._robots) == 1
        for agent, robot in self._robots.items():
            notes: list[str] = []
            sensors = robot.sensors()
            odometry = next((s for s in sensors if s.topic == robot.topics.odometry), None)
            way: Matrix | None = None
            if robot.placed is not None:
                way = self._frames.way(fixed, robot.placed.frame)
                if way is None:
                    notes.append(_unrelated(robot.placed.frame, fixed))
                    way = np.eye(4)
                pose: Matrix | None = way @ robot.placed.pose
            else:
                pose = robot.pose_by_tf(self._frames, fixed, robot.base(agent, alone=alone))
            if pose is not None:
                x, y = pose[:2, 3].tolist()
                places[agent] = (x, y, heading(pose))
            if odometry is not None and odometry.is_silent(now):
                lost.add(agent)
            points[agent], more = robot.points(self._frames, fixed, way, now)
            camera = robot.camera(self._known.of(agent).camera)
            states[agent] = RobotState(sensors, camera, (*notes, *more))
        corners = map_state.grid.corners() if map_state.grid is not None else None
        scene = robot_scene(places, ground(places, points, corners)) if places else None
        return Robots(
            MappingProxyType(states),
            scene,
            frozenset(lost),
            scans_frame(scene.names, points) if scene is not None else b"",
            map_state,
        )

    def _fixed(self, grid: Grid | None) -> str:
        """Return the frame in which all is drawn: of the map, if there is one."""
        if grid is not None:
            return grid.frame
        placed = [robot.placed for robot in self._robots.values() if robot.placed is not None]
        if any(self._frames.way(MAP_FRAME, one.frame) is not None for one in placed):
            return MAP_FRAME
        return placed[0].frame if placed else MAP_FRAME

    def _map_state(self) -> MapState:
        before = self._known.map
        if (reading := self._map) is None:
            sensor = None
            if self._map_topic:
                publishers = self._link.node.count_publishers(self._map_topic)
                sensor = SensorState(self._map_topic, MAP.rsplit("/", 1)[-1], publishers)
            return MapState(sensor, before.number, before.grid, self._map_choices)
        publishers = self._link.node.count_publishers(reading.listening.topic)
        sensor = reading.listening.state(MAP, publishers, reading.trouble)
        grid = reading.value if reading.number else before.grid  # until it comes again
        return MapState(sensor, before.number + (grid is not before.grid), grid, self._map_choices)

    def _tell(self) -> None:
        """Say once why something is not shown."""
        readings = [reading for robot in self._robots.values() for reading in robot.readings()]
        for reading in [*readings, *([self._map] if self._map is not None else [])]:
            topic = reading.listening.topic
            if (why := reading.refusal) and topic not in self._told:
                self._told.add(topic)
                self._refuse(f"{topic} {why}.")


def _unrelated(frame: str, fixed: str) -> str:
    return (
        f"Nobody says by tf where {frame or 'the frame of its odometry'} lies in {fixed}: it is "
        "drawn as if both were the same."
    )
