"""The sensors of a robot: each reads plain numbers from a standard message.

No ROS here: a sensor takes any object with the fields of its message. Values are in SI units and
the axes of REP 103. A value that was not measured, or is infinite, is NaN.
"""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from hitab_core import VocabularyError
from hitab_robots.mount import Mount

SENSOR_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
SENSOR_NAME_RULE = "use letters, digits and _, not beginning with a digit"
CHARGING = 1
"""`POWER_SUPPLY_STATUS_CHARGING` of `sensor_msgs/BatteryState`."""


def check_name(what: str, name: str) -> None:
    """Check that a name can be part of the name of a value and of a parameter.

    Raises:
        VocabularyError: if it cannot.
    """
    if SENSOR_NAME.match(name) is None:
        raise VocabularyError(f'"{name}" is not a name for {what}; {SENSOR_NAME_RULE}')


@dataclass(frozen=True, kw_only=True)
class Sensor(ABC):
    """A sensor of a robot, as plain data.

    Attributes:
        name: the sensor's name, with which the names of its values begin, such as ``odom.x``.
        topic: the topic, relative to the robot's namespace; empty if equal to the name.
        patience: age, s, from which on all values of a reading are NaN.
        mount: the sensor's place on the robot; None if it does not matter.
    """

    message: ClassVar[str] = ""
    """Type of the sensor's messages, such as ``sensor_msgs/msg/LaserScan``."""

    reads: ClassVar[tuple[str, ...]] = ()
    """The names of the sensor's values, if they are always the same."""

    name: str = ""
    topic: str = ""
    patience: float = 0.5
    mount: Mount | None = None

    def __post_init__(self) -> None:
        check_name("a sensor", self.name)
        if not self.patience > 0.0:
            raise VocabularyError(
                f'the patience of sensor "{self.name}" is {self.patience:g} s; it must be above 0'
            )

    def check_distinct(self, what: str, names: Sequence[str]) -> None:
        """Check that a list of names has at least one name, and none twice.

        Raises:
            VocabularyError: if not.
        """
        if not names or len({*names}) < len(names):
            raise VocabularyError(
                f'the {what} of sensor "{self.name}" are {", ".join(names) or "none"}; '
                "name at least one, each once"
            )

    @property
    def topic_name(self) -> str:
        """The sensor's topic, relative to the robot's namespace."""
        return self.topic or self.name

    @property
    def fields(self) -> tuple[str, ...]:
        """The names of the sensor's values, in the order of `read`."""
        return self.reads

    @property
    def values(self) -> tuple[str, ...]:
        """The full names of the sensor's values, such as ``odom.x``."""
        return tuple(f"{self.name}.{field}" for field in self.fields)

    @abstractmethod
    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return the values in a message, a number for each of `fields`.

        Args:
            message: a message of the sensor's type, or any object with its fields.
            mount: the sensor's place on the robot; None for the declared mount.
        """

    def reach(self, message: Any) -> float:
        """Return the sensor's longest range, m; infinite if it measures none."""
        return math.inf


def finite(value: float) -> float:
    """Return a number, or NaN if it is infinite."""
    return float(value) if math.isfinite(value) else math.nan


def angles_of(rotation: Any) -> tuple[float, float, float]:
    """Return roll, pitch and yaw of a quaternion, rad; NaN if it is invalid, such as all zeros."""
    x, y, z, w = rotation.x, rotation.y, rotation.z, rotation.w
    length = math.sqrt(x * x + y * y + z * z + w * w)
    if not 0.5 < length < 2.0:
        return math.nan, math.nan, math.nan
    x, y, z, w = x / length, y / length, z / length, w / length
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    yaw = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return roll, pitch, yaw


@dataclass(frozen=True, kw_only=True)
class Odometry(Sensor):
    """A `nav_msgs/Odometry`.

    It reads the place ``x``, ``y`` in m and the ``heading`` in rad, in the frame of the odometry;
    the speeds ``vx`` ahead and ``vy`` to the left in m/s, and the ``turn_rate`` in rad/s.
    """

    message: ClassVar[str] = "nav_msgs/msg/Odometry"
    reads: ClassVar[tuple[str, ...]] = ("x", "y", "heading", "vx", "vy", "turn_rate")
    name: str = "odom"

    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return the pose and the speeds."""
        pose, twist = message.pose.pose, message.twist.twist
        return [
            finite(pose.position.x),
            finite(pose.position.y),
            angles_of(pose.orientation)[2],
            finite(twist.linear.x),
            finite(twist.linear.y),
            finite(twist.angular.z),
        ]


@dataclass(frozen=True, kw_only=True)
class Battery(Sensor):
    """A `sensor_msgs/BatteryState`: ``percentage`` from 0 to 1, ``voltage`` in V, ``charging``.

    Attributes:
        percent: whether the robot's driver counts to 100, unlike the message's definition.
    """

    message: ClassVar[str] = "sensor_msgs/msg/BatteryState"
    reads: ClassVar[tuple[str, ...]] = ("percentage", "voltage", "charging")
    name: str = "battery_state"
    patience: float = 15.0
    percent: bool = False

    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return the state of the battery."""
        charge = finite(message.percentage) / (100.0 if self.percent else 1.0)
        charging = float(message.power_supply_status == CHARGING)
        return [charge, finite(message.voltage), charging]


@dataclass(frozen=True, kw_only=True)
class Imu(Sensor):
    """A `sensor_msgs/Imu`.

    It reads ``roll``, ``pitch`` and ``heading`` in rad, the ``turn_rate`` in rad/s, and the
    accelerations ``ax``, ``ay``, ``az`` in m/s². Values marked as not measured, by a covariance
    that begins with -1, are NaN.
    """

    message: ClassVar[str] = "sensor_msgs/msg/Imu"
    reads: ClassVar[tuple[str, ...]] = ("roll", "pitch", "heading", "turn_rate", "ax", "ay", "az")
    name: str = "imu"

    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return attitude, turn rate and accelerations."""
        attitude: tuple[float, ...] = (math.nan,) * 3
        if message.orientation_covariance[0] != -1:
            attitude = angles_of(message.orientation)
        turn_rate = math.nan
        if message.angular_velocity_covariance[0] != -1:
            turn_rate = finite(message.angular_velocity.z)
        accelerations = [math.nan] * 3
        if message.linear_acceleration_covariance[0] != -1:
            a = message.linear_acceleration
            accelerations = [finite(a.x), finite(a.y), finite(a.z)]
        return [*attitude, turn_rate, *accelerations]


@dataclass(frozen=True, kw_only=True)
class Range(Sensor):
    """A `sensor_msgs/Range`, such as a sonar: the ``range`` in m.

    It is the maximum if nothing is within range, the minimum if something is too near to be
    measured (REP 117, also for sensors that only tell whether something is there), and NaN if
    nothing was measured.
    """

    message: ClassVar[str] = "sensor_msgs/msg/Range"
    reads: ClassVar[tuple[str, ...]] = ("range",)
    name: str = "range"

    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return the distance to the nearest thing in front of the sensor."""
        distance, least, most = message.range, message.min_range, self.reach(message)
        if distance == -math.inf:
            return [finite(least)]
        if distance >= most:
            return [finite(most)]
        return [finite(distance) if distance >= least else math.nan]

    def reach(self, message: Any) -> float:
        """Return the sensor's longest range, m."""
        return float(message.max_range)


@dataclass(frozen=True, kw_only=True)
class Joints(Sensor):
    """A `sensor_msgs/JointState`: position and velocity of some joints.

    A joint ``left_wheel`` has the values ``left_wheel.position`` and ``left_wheel.velocity``, in
    rad and rad/s, or in m and m/s for a sliding joint. They are NaN if a message lacks the joint.

    Attributes:
        joints: names of the joints.
    """

    message: ClassVar[str] = "sensor_msgs/msg/JointState"
    name: str = "joint_states"
    joints: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_distinct("joints", self.joints)

    @property
    def fields(self) -> tuple[str, ...]:
        """The names of the sensor's values."""
        return tuple(
            f"{joint}.{what}" for joint in self.joints for what in ("position", "velocity")
        )

    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return position and velocity of each joint."""
        index = {name: i for i, name in enumerate(message.name)}
        return [
            finite(numbers[index[joint]])
            if joint in index and index[joint] < len(numbers)
            else math.nan
            for joint in self.joints
            for numbers in (message.position, message.velocity)
        ]
