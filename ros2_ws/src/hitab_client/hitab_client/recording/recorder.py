"""Records the messages of a swarm, and of robots, as a bag."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hitab_msgs.msg import (
    Action,
    AgentStatus,
    Command,
    CommanderStatus,
    Distribution,
    DistributionAck,
    Episode,
    Order,
    Percept,
    TransitionEvent,
    WorldState,
    WorldStatus,
)
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from visualization_msgs.msg import MarkerArray

from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_client.recording.bag_file import BagFile
from hitab_client.recording.message_definitions import definition, message_class, type_name
from hitab_ros import names, own_hash, qos

RECORDED_TOPICS: Mapping[str, tuple[Any, QoSProfile]] = {
    "state": (WorldState, qos.LATCHED),
    "actions": (Action, qos.ROLL_CALL),
    "episodes": (Episode, qos.EVENTS),
    "transitions": (TransitionEvent, qos.EVENTS),
    "command": (Command, qos.EVENTS),
    "group": (CommanderStatus, qos.LATCHED),
    "order": (Order, qos.LATCHED),
    "distribution": (Distribution, qos.EVENTS),
    "distribution_ack": (DistributionAck, qos.EVENTS),
    "markers": (MarkerArray, qos.LATCHED),
}
"""Recorded topics in addition to all statuses, by the last part of their names."""

STATUSES = (WorldStatus, AgentStatus)

DEPTH = 1000
"""Maximum number of a topic's messages that wait while this process is busy."""

NO_HASH = "INVALID"
"""Hash that rclpy reports for an unannounced definition, such as from other ROS 2 versions."""

ROBOT_PACKAGES = frozenset({"geometry_msgs", "nav_msgs", "sensor_msgs", "tf2_msgs"})
"""Packages with the usual messages of robots."""

PERCEIVING_MAX = 64
"""Maximum number of agents whose percepts are recorded."""


class Recorder:
    """Recorder of every topic of a swarm, including topics that appear later.

    Messages are not deserialized: they are written as received, with the times of sending and of
    receipt. Percepts are recorded of each agent with a process of its own.

    Attributes:
        bag: the written bag.
        problem: why nothing more can be written; empty if nothing is wrong.
        left_out: reasons why topics of robots cannot be recorded, by topic.
    """

    def __init__(
        self,
        link: RosLink,
        path: str | Path,
        *,
        also: Collection[str] = (),
        robots: bool = False,
    ) -> None:
        """Start recording.

        Args:
            link: connection to the ROS domain.
            path: path of the file.
            also: full names of further topics, such as those of a robot.
            robots: whether to record every topic with a type from `ROBOT_PACKAGES`, too.

        Raises:
            SwarmError: if the file cannot be written, or a type of ``also`` is not installed.
        """
        self.problem = ""
        self.left_out: dict[str, str] = {}
        self._link = link
        self._also = {*also}
        self._robots = robots
        self._subscriptions: dict[str, Any] = {}
        self._offered: dict[str, set[Any]] = {}
        self._channels: dict[str, int] = {}
        self._agents: set[str] = set()
        self._heard: set[str] = set()
        self.bag = BagFile(Path(path))
        try:
            self.look()
        except BaseException:
            self.close()
            raise

    @property
    def missing(self) -> list[str]:
        """The chosen topics without a publisher yet."""
        return sorted(self._also - set(self._subscriptions))

    @property
    def perceiving(self) -> list[str]:
        """The agents, with their namespaces, whose percepts are being recorded."""
        return sorted(self._heard)

    @property
    def awaited(self) -> list[str]:
        """The agents whose percepts have not arrived yet."""
        return sorted(self._agents - self._heard)

    def look(self) -> None:
        """Find new topics, and write all buffered messages to the system.

        Raises:
            SwarmError: if the type of a chosen topic is not installed.
        """
        for topic, kinds in self._link.node.get_topic_names_and_types():
            if topic in self._subscriptions and topic not in self._offered:
                continue
            if topic in self._also:
                self._subscribe_as_offered(topic, kinds[0])
            elif self._robots and kinds[0].split("/")[0] in ROBOT_PACKAGES:
                try:
                    self._subscribe_as_offered(topic, kinds[0])
                except SwarmError as error:
                    self.left_out[topic] = str(error)
            else:
                for kind, profile in self._wanted(topic):
                    if type_name(kind) in kinds:
                        self._subscribe(topic, kind, profile)
        for agent in self._alone():
            if len(self._agents) < PERCEIVING_MAX:
                self._agents.add(agent)
                self._subscribe(f"{agent}/{names.PERCEIVED}", Percept, qos.PERCEIVED, agent)
        if not self.problem:
            try:
                self.bag.flush()
            except OSError as error:
                self._end(error)

    def _end(self, error: OSError) -> None:
        self.problem = f"The recording to {self.bag.path} ends here: {error.strerror}"

    def _wanted(self, topic: str) -> list[tuple[Any, QoSProfile]]:
        name = topic.rsplit("/", 1)[-1]
        if name == "status":
            return [(kind, qos.LATCHED) for kind in STATUSES]
        return [RECORDED_TOPICS[name]] if name in RECORDED_TOPICS else []

    def _alone(self) -> Iterator[str]:
        """Yield the namespaces of agents in processes of their own, which have parameters."""
        ending = "/agent/get_parameters"
        for service, _ in self._link.node.get_service_names_and_types():
            agent = service.removesuffix(ending)
            if agent != service and agent not in self._agents:
                yield agent

    def _subscribe_as_offered(self, topic: str, kind: str) -> None:
        """Subscribe with a QoS that matches all publishers; repeat when the publishers change."""
        ends = self._link.node.get_publishers_info_by_topic(topic)
        before = self._offered.get(topic)
        offered = {(e.qos_profile.reliability, e.qos_profile.durability) for e in ends}
        if not ends or offered == before:
            return
        self._refuse_other_definition(ends, kind)
        reliable = all(r == ReliabilityPolicy.RELIABLE for r, _ in offered)
        latched = all(d == DurabilityPolicy.TRANSIENT_LOCAL for _, d in offered)
        if topic in self._subscriptions:
            self._link.node.destroy_subscription(self._subscriptions.pop(topic))
        profile = QoSProfile(
            depth=DEPTH,
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=(
                DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE
            ),
        )
        self._subscribe(topic, message_class(kind), profile)
        self._offered[topic] = offered

    def _refuse_other_definition(self, ends: Iterable[Any], kind: str) -> None:
        """Raise if a publisher's definition differs from the one that goes into the file."""
        message_class(kind)
        for end in ends:
            if str(end.topic_type_hash) not in (own_hash(kind), NO_HASH):
                raise SwarmError(
                    f"{end.node_name} publishes messages with another definition of {kind} than "
                    "is installed here; install the same version of that package"
                )

    def _subscribe(self, topic: str, kind: Any, profile: QoSProfile, agent: str = "") -> None:
        name = type_name(kind)
        definition(name)  # raises if the type cannot be recorded

        def take(data: bytes, information: Mapping[str, Any]) -> None:
            if self.problem:
                return
            if agent:
                self._heard.add(agent)
            now = time.time_ns()
            try:
                if topic not in self._channels:  # the publishers are known by now
                    self._channels[topic] = self._channel(topic, name, profile)
                received = information.get("received_timestamp") or now
                sent = information.get("source_timestamp") or received
                self.bag.write(self._channels[topic], data, received, sent)
            except OSError as error:
                self._end(error)

        self._subscriptions[topic] = self._link.node.create_subscription(
            kind, topic, take, profile, raw=True, temporary=True, checked=False
        )

    def _channel(self, topic: str, kind: str, requested: QoSProfile) -> int:
        publishers = self._link.node.get_publishers_info_by_topic(topic)
        offered = [publisher.qos_profile for publisher in publishers] or [requested]
        return self.bag.add_topic(topic, kind, offered, own_hash(kind))

    def close(self) -> None:
        """Write the index and close the file.

        Raises:
            SwarmError: if the file cannot be written.
        """
        for subscription in self._subscriptions.values():
            self._link.node.destroy_subscription(subscription)
        self._subscriptions.clear()
        self.bag.close()
