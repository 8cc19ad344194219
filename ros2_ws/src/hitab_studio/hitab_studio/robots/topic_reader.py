"""The newest message of a robot's topic: its content and age."""

from __future__ import annotations

import time
from typing import Any

from rclpy.qos import qos_profile_sensor_data
from rclpy.serialization import deserialize_message

from hitab_client import RosLink, SwarmError
from hitab_client.recording import message_class
from hitab_ros import qos
from hitab_ros.timing import SILENT_AFTER_S
from hitab_studio.robots.robot_messages import (
    ROBOT_MESSAGE_BYTES_MAX,
    Refused,
    map_of,
    odometry_of,
    picture_of,
    scan_of,
)
from hitab_studio.robots.topics import CAMERA, MAP, ODOM_TYPE, SCAN

READERS = {ODOM_TYPE: odometry_of, SCAN: scan_of, MAP: map_of, CAMERA: picture_of}


class TopicReader:
    """Keeps the newest message of a topic.

    Attributes:
        value: content of the last message; None before the first or if invalid.
        trouble: reason for which the message or the topic cannot be used; "" if none.
    """

    def __init__(self, link: RosLink, topic: str, kind: str) -> None:
        """Subscribe to the topic, if the message type is installed."""
        self.value: Any = None
        self.trouble = ""
        self._node = link.node
        self._read = READERS.get(kind)
        self._heard: float | None = None
        self._new: bytes | None = None
        self._subscription: Any = None
        try:
            self._class = message_class(kind)
        except SwarmError as error:
            self.trouble = str(error)
            return
        quality = qos.LATCHED if kind == MAP else qos_profile_sensor_data
        self._subscription = link.node.create_subscription(
            self._class, topic, self._take, quality, raw=True, temporary=True
        )

    def _take(self, data: bytes) -> None:
        self._heard, self._new = time.monotonic(), data

    def look(self) -> None:
        """Decode the newest message, and skip older ones."""
        data, self._new = self._new, None
        if data is None or self._read is None:
            return
        try:
            self.value, self.trouble = self._read(self._message(data)), ""
        except Refused as error:
            self.value, self.trouble = None, str(error)

    def _message(self, data: bytes) -> Any:
        if len(data) > ROBOT_MESSAGE_BYTES_MAX:
            raise Refused(f"sends {len(data) / 1e6:.0f} MB in one message, too many to show")
        try:
            return deserialize_message(data, self._class)
        except Exception as error:  # the type depends on the middleware
            why = " ".join(str(error).split())[:100]
            raise Refused(f"sends an invalid {self._class.__name__}: {why}") from None

    @property
    def age(self) -> float | None:
        """Time since the last message, s; None before the first."""
        return None if self._heard is None else time.monotonic() - self._heard

    @property
    def is_silent(self) -> bool:
        """Whether the last message is too old."""
        return self.age is None or self.age > SILENT_AFTER_S

    def close(self) -> None:
        """Stop listening."""
        if self._subscription is not None:
            self._node.destroy_subscription(self._subscription)
