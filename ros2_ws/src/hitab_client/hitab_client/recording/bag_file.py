"""Bag in one MCAP file, with the metadata that ``ros2 bag`` expects.

See rosbag2 of ROS 2 Jazzy: ``rosbag2_storage/src/qos.cpp`` and
``rosbag2_storage_mcap/src/mcap_storage.cpp``.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import Writer
from rclpy.qos import QoSProfile

from hitab_client.errors import SwarmError
from hitab_client.recording.message_definitions import definition
from hitab_ros.messages.stamps import NANOSECONDS

METADATA = "hitab"
"""Name of the metadata record; recordings without one have the first format."""

BAG_FORMAT = 1
"""Format version that is written."""


class BagFile:
    """A bag that is being written.

    Attributes:
        path: path of the file.
        count: number of messages.
    """

    def __init__(self, path: Path) -> None:
        """Create the file, which must not exist yet.

        Raises:
            SwarmError: if the file cannot be written.
        """
        self.path = path
        self.count = 0
        self._schemas: dict[str, int] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("xb")
        except FileExistsError:
            raise SwarmError(f"{path} exists already; choose another name") from None
        except OSError as error:
            raise SwarmError(f"cannot record to {path}: {error.strerror}") from None
        self._writer = Writer(self._file, enable_data_crcs=True)
        self._writer.start(profile="ros2", library="hitab_client")
        self._writer.add_metadata(METADATA, {"format": str(BAG_FORMAT)})

    def add_topic(
        self, topic: str, kind: str, offered: Sequence[QoSProfile], type_hash: str
    ) -> int:
        """Add a topic; return its channel.

        Args:
            topic: full name of the topic.
            kind: name of the topic's type.
            offered: QoS profiles of the topic's publishers.
            type_hash: hash of the type's definition, as ROS 2 announces it.

        Raises:
            SwarmError: if the type's definition is not installed.
        """
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(
                name=kind, encoding="ros2msg", data=definition(kind).encode()
            )
        return self._writer.register_channel(
            topic=topic,
            message_encoding="cdr",
            schema_id=self._schemas[kind],
            metadata={
                "offered_qos_profiles": yaml.safe_dump(
                    [qos_record(profile) for profile in offered], sort_keys=False
                ),
                "topic_type_hash": type_hash,
            },
        )

    def write(self, channel: int, data: bytes, received: int, sent: int) -> None:
        """Write a message.

        Args:
            channel: channel of the message's topic.
            data: serialized message.
            received: time of receipt, ns since 1970.
            sent: time of sending, ns since 1970.

        Raises:
            OSError: if the file cannot be written.
        """
        self._writer.add_message(channel, log_time=received, data=data, publish_time=sent)
        self.count += 1

    def flush(self) -> None:
        """Write all buffered data to the system, where it survives this process.

        Raises:
            OSError: if the file cannot be written.
        """
        self._writer.flush()

    def close(self) -> None:
        """Write the index and close the file.

        Raises:
            SwarmError: if the file cannot be written.
        """
        try:
            with self._file:
                self._writer.finish()
        except OSError as error:
            raise SwarmError(f"{self.path} is not complete: {error.strerror}") from None


def qos_record(profile: QoSProfile) -> dict[str, Any]:
    """Return a QoS profile as ``ros2 bag`` of Jazzy writes it."""
    return {
        "history": profile.history.short_key,
        "depth": profile.depth,
        "reliability": profile.reliability.short_key,
        "durability": profile.durability.short_key,
        "deadline": _time(profile.deadline),
        "lifespan": _time(profile.lifespan),
        "liveliness": profile.liveliness.short_key,
        "liveliness_lease_duration": _time(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def _time(duration: Any) -> dict[str, int]:
    seconds, rest = divmod(duration.nanoseconds, NANOSECONDS)
    return {"sec": seconds, "nsec": rest}
