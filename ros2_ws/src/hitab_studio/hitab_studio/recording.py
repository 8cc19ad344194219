"""Records the messages of a swarm as MCAP, which Foxglove and ``ros2 bag play`` can read."""

from __future__ import annotations

import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from hitab_msgs.msg import (
    AgentStatus,
    Command,
    CommanderStatus,
    Distribution,
    DistributionAck,
    Episode,
    Order,
    TransitionEvent,
    WorldState,
    WorldStatus,
)
from mcap.writer import Writer
from rclpy.qos import QoSProfile
from visualization_msgs.msg import MarkerArray

from hitab_client import RosLink, SwarmError
from hitab_ros import qos
from hitab_studio.message_text import definition, type_name

KINDS: Mapping[str, tuple[Any, QoSProfile]] = {
    "state": (WorldState, qos.LATCHED),
    "episodes": (Episode, qos.EVENTS),
    "transitions": (TransitionEvent, qos.EVENTS),
    "command": (Command, qos.EVENTS),
    "group": (CommanderStatus, qos.LATCHED),
    "order": (Order, qos.LATCHED),
    "distribution": (Distribution, qos.EVENTS),
    "distribution_ack": (DistributionAck, qos.EVENTS),
    "markers": (MarkerArray, qos.LATCHED),
}
"""What is recorded besides all statuses, by the last part of the topic's name."""

STATUSES = (WorldStatus, AgentStatus)

METADATA = "hitab"
"""Name of the metadata record; recordings without one have the first format."""

FORMAT = 1
"""The format version that is written."""


class Recorder:
    """Records every topic of the swarm, including those that appear later.

    Messages are not deserialized: they are written as received.

    Attributes:
        count: number of recorded messages.
        problem: why nothing more can be written; "" if nothing is wrong.
    """

    def __init__(self, link: RosLink, path: str | Path) -> None:
        """Start recording.

        Raises:
            SwarmError: if the file cannot be written.
        """
        self.path = Path(path)
        self.count = 0
        self.problem = ""
        self._link = link
        self._subscriptions: dict[str, Any] = {}
        self._schemas: dict[str, int] = {}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = self.path.open("xb")
        except OSError as error:
            raise SwarmError(f"cannot record to {self.path}: {error.strerror}") from None
        self._writer = Writer(self._file)
        self._writer.start(profile="ros2", library="hitab_studio")
        self._writer.add_metadata(METADATA, {"format": str(FORMAT)})
        self.look()

    def look(self) -> None:
        """Find new topics."""
        for topic, kinds in self._link.node.get_topic_names_and_types():
            if topic in self._subscriptions:
                continue
            name = topic.rsplit("/", 1)[-1]
            wanted = [KINDS[name]] if name in KINDS else []
            if name == "status":
                wanted = [(kind, qos.LATCHED) for kind in STATUSES]
            for kind, profile in wanted:
                if type_name(kind) in kinds:
                    self._subscribe(topic, kind, profile)

    def _subscribe(self, topic: str, kind: Any, profile: QoSProfile) -> None:
        name = type_name(kind)
        if name not in self._schemas:
            self._schemas[name] = self._writer.register_schema(
                name=name, encoding="ros2msg", data=definition(name).encode()
            )
        channel = self._writer.register_channel(
            topic=topic, message_encoding="cdr", schema_id=self._schemas[name]
        )

        def take(data: bytes) -> None:
            if self.problem:
                return
            now = time.time_ns()
            try:
                self._writer.add_message(channel, log_time=now, data=data, publish_time=now)
            except OSError as error:
                self.problem = f"The recording to {self.path} ends here: {error.strerror}"
            else:
                self.count += 1

        self._subscriptions[topic] = self._link.node.create_subscription(
            kind, topic, take, profile, raw=True
        )

    def close(self) -> None:
        """Write the index and close the file.

        Raises:
            SwarmError: if it cannot be written.
        """
        for subscription in self._subscriptions.values():
            self._link.node.destroy_subscription(subscription)
        self._subscriptions.clear()
        try:
            with self._file:
                self._writer.finish()
        except OSError as error:
            raise SwarmError(f"{self.path} is not complete: {error.strerror}") from None
