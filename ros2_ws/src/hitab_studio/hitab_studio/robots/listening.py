"""One topic of a robot: its newest message as it came, and whether it is silent."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data

from hitab_client import RosLink, SwarmError
from hitab_client.recording import message_class
from hitab_studio.robots.messages import Refused, read, stamp_of

MESSAGE_BYTES = 1_000_000
"""Of a sensor; what is larger is refused."""

BARRED_SECONDS = 60.0
"""How long a topic is not listened to after a message that was too large."""

PATIENCE_SECONDS = 2.0
PATIENCE_OF_KIND = {"BatteryState": 15.0}
"""As long as the sensors of `hitab_robots` have, where that is longer."""

DIFFERENT_CLOCKS = 86400.0
"""s; a stamp that is farther from now is one of a simulation, or of no clock at all."""

AHEAD_SECONDS = 0.5


@dataclass(frozen=True)
class SensorState:
    """What is known of a sensor.

    Attributes:
        topic: its topic.
        kind: its type without the package, such as ``LaserScan``.
        publishers: how many there are; 0: nobody publishes it.
        since: since when it is listened to, s, on the monotonic clock; None: it is not.
        heard: when its last message came, on the same clock; None: none came.
        trouble: what is wrong with its messages; "": nothing.
    """

    topic: str
    kind: str
    publishers: int
    since: float | None = None
    heard: float | None = None
    trouble: str = ""

    @property
    def patience(self) -> float:
        """How long it may say nothing, s."""
        return PATIENCE_OF_KIND.get(self.kind, PATIENCE_SECONDS)

    def is_silent(self, now: float) -> bool:
        """Whether it has said nothing for too long."""
        last = self.heard if self.heard is not None else self.since
        return last is not None and now - last > self.patience


class Listening:
    """Keeps the newest message of a topic.

    Attributes:
        topic: its name.
        data: the newest message; None: none came, or it was refused.
        number: how many came.
        heard: when the last one came, s, on the monotonic clock; None: none came.
        trouble: what is wrong; "": nothing.
    """

    def __init__(self, link: RosLink, topic: str, kind: str, limit: int = MESSAGE_BYTES) -> None:
        """Listen from now on, unless the type is not installed.

        Args:
            link: the node to use.
            topic: its topic.
            kind: its type.
            limit: bytes; a message that is larger is refused, and no other one taken for a while.
        """
        self.data: bytes | None = None
        self.number = 0
        self.heard: float | None = None
        self.since = time.monotonic()
        self.trouble = ""
        self.topic = topic
        self._link, self._kind, self._limit = link, kind, limit
        self._barred_until = 0.0
        self._subscription: Any = None
        self._class: Any = None
        self._read = 0  # the number of the message that was read last
        self._message: Any = None
        self._unreadable = ""
        self._open()

    def _open(self) -> None:
        try:
            self._class = message_class(self._kind)
        except SwarmError as error:
            self.trouble = str(error)
            return
        self._subscription = self._link.node.create_subscription(
            self._class, self.topic, self._take, self._profile(), raw=True, temporary=True
        )

    def _profile(self) -> QoSProfile:
        """Return a quality that all publishers offer, with what they have kept if all do so."""
        offered = [
            info.qos_profile for info in self._link.node.get_publishers_info_by_topic(self.topic)
        ]
        kept = [
            one.durability == DurabilityPolicy.TRANSIENT_LOCAL
            and one.reliability == ReliabilityPolicy.RELIABLE
            for one in offered
        ]
        if not kept or not all(kept):
            return QoSProfile(
                depth=1,
                reliability=qos_profile_sensor_data.reliability,
                durability=qos_profile_sensor_data.durability,
            )
        return QoSProfile(
            depth=1,
            reliability=ReliabilityPolicy.RELIABLE,
            durability=DurabilityPolicy.TRANSIENT_LOCAL,
        )

    def _take(self, data: bytes) -> None:
        self.heard = time.monotonic()
        self.number += 1
        if len(data) > self._limit:
            self.data = None
            self.trouble = (
                f"sends {len(data) / 1e6:.0f} MB in one message; up to "
                f"{self._limit / 1e6:.0f} MB are shown"
            )
            self._barred_until = self.heard + BARRED_SECONDS
        else:
            self.data = data

    def look(self) -> None:
        """Stop listening to what sends too much, and try again after a while."""
        if self._barred_until and self._subscription is not None:
            self._link.node.destroy_subscription(self._subscription)
            self._subscription = None
        elif self._barred_until and time.monotonic() > self._barred_until:
            self._barred_until = 0.0
            self._open()

    def message(self) -> Any:
        """Return the newest message, read once; None: none came, or it was too large.

        Raises:
            Refused: if it is none of its type.
        """
        if self._read != self.number:
            self._read, self._message, self._unreadable = self.number, None, ""
            try:
                self._message = None if self.data is None else read(self._class, self.data)
            except Refused as error:
                self._unreadable = str(error)
        if self._unreadable:
            raise Refused(self._unreadable)
        return self._message

    def state(self, kind: str, publishers: int, trouble: str = "") -> SensorState:
        """Return what is known of the sensor.

        Args:
            kind: its type.
            publishers: how many there are.
            trouble: what is wrong with what its messages say.
        """
        return SensorState(
            self.topic,
            kind.rsplit("/", 1)[-1],
            publishers,
            self.since,
            self.heard,
            self.trouble or trouble or self._trouble_of_stamp(),
        )

    def _trouble_of_stamp(self) -> str:
        if self.data is None or self.heard is None:
            return ""
        try:
            stamp = stamp_of(self.message())
        except Refused as error:
            return str(error)
        age = time.time() - (time.monotonic() - self.heard) - stamp
        if stamp <= 0.0 or abs(age) > DIFFERENT_CLOCKS:
            return ""
        if age > PATIENCE_OF_KIND.get(self._kind.rsplit("/", 1)[-1], PATIENCE_SECONDS):
            return f"is {age:.1f} s old when it comes: set the clocks of both computers"
        if age < -AHEAD_SECONDS:
            return f"has stamps {-age:.1f} s ahead of the clock: set the clocks of both computers"
        return ""

    def close(self) -> None:
        """Stop listening."""
        if self._subscription is not None:
            self._link.node.destroy_subscription(self._subscription)
            self._subscription = None
