"""The parameters and topics of a robot's link, on the agent's node, and of its relay."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from hitab_core import HitabError
from hitab_robots.relay.velocity import Drive

BASE_TOPIC = "cmd_vel"
"""Topic of velocities to the base; relative to the robot's namespace."""

AGENT_VELOCITY_TOPIC = "cmd_vel_agent"
"""Topic of velocities from an agent to its relay, `TwistStamped`; relative to the namespace."""

HEARTBEAT = "agent_heartbeat"
"""Topic of an agent's signs of life for its relay; relative to the agent's namespace."""

ODOMETRY_TOPIC = "odom"
"""Topic by which a relay checks that the robot stands still; relative to its namespace."""

RELAY_SETTINGS = {
    "max_velocity": "m/s ahead, m/s to the left, rad/s; also backwards",
    "max_accel": "how fast the robot may gain speed, per s",
    "max_decel": "how fast it may lose speed, per s, unless it has to stop",
    "enable_stamped_cmd_vel": "whether the base takes TwistStamped instead of Twist",
    "cmd_vel_timeout": "s without a velocity of the agent after which the robot stops",
    "smoothing_frequency": "Hz; how often a velocity is sent to the base",
    "auto_rearm": "act again without re-arming after a stop: a risk",
}
"""Parameters that the link passes on to its relay."""

RELAY_PARAMETERS = {
    **RELAY_SETTINGS,
    "rate": "Hz; how often the agent decides and acts",
    "relay": "start the relay; false if it is started elsewhere",
    "base_frame": "the robot's frame, such as base_link, to look up the sensors' places in tf2; "
    "empty to take them from the sensors' parameters",
    "state_dir": "folder in which an emergency stop survives a crash; empty for none",
    "agent_pid": "the agent's process: the relay ends after it; 0 for none",
    "kills_hung_agent": "kill the agent when it hangs; its supervisor restarts it",
}
SENSOR_PARAMETERS = {
    "patience": "s; an older reading has no value",
    "x": "m; the sensor's place in the robot's frame",
    "y": "m; the sensor's place in the robot's frame",
    "yaw": "rad; the sensor's direction in the robot's frame",
    "upside_down": "whether the sensor is turned over about its x axis",
}
"""Parameters after the name of a sensor, such as ``scan.yaw``."""


def declare(node: Node, name: str, default: Any) -> Any:
    """Declare a parameter that does not change, and return its value."""
    if node.has_parameter(name):  # the agent's node has it already
        return node.get_parameter(name).value
    sensor, _, field = name.rpartition(".")
    description = SENSOR_PARAMETERS[field] if sensor else RELAY_PARAMETERS[name]
    descriptor = ParameterDescriptor(description=description, read_only=True)
    return node.declare_parameter(name, default, descriptor).value


def declare_number(node: Node, name: str, default: float) -> float:
    """Declare a number that must be above zero, such as a rate, and return its value.

    Raises:
        HitabError: if the number is not above zero.
    """
    value = float(declare(node, name, default))
    if not 0.0 < value < math.inf:
        raise HitabError(f"the parameter {name} is {value:g}; it must be above 0")
    return value


@dataclass(frozen=True)
class RelaySettings:
    """The settings of a relay; each of its fields, and of the drive's fields, is a parameter."""

    drive: Drive
    cmd_vel_timeout: float = 0.3
    smoothing_frequency: float = 20.0
    auto_rearm: bool = False

    @classmethod
    def declare(cls, node: Node, drive: Drive) -> RelaySettings:
        """Declare the parameters and return their values.

        Args:
            node: the node of the agent or the relay.
            drive: the defaults.

        Raises:
            HitabError: if a value makes no sense.
        """

        def limits(name: str) -> Any:
            return tuple(map(float, declare(node, name, list(getattr(drive, name)))))

        stamped = declare(node, "enable_stamped_cmd_vel", drive.enable_stamped_cmd_vel)
        return cls(
            Drive(limits("max_velocity"), limits("max_accel"), limits("max_decel"), stamped),
            declare_number(node, "cmd_vel_timeout", cls.cmd_vel_timeout),
            declare_number(node, "smoothing_frequency", cls.smoothing_frequency),
            declare(node, "auto_rearm", cls.auto_rearm),
        )

    def arguments(self) -> Iterator[str]:
        """Yield the command-line arguments that give a relay these settings."""
        for name in RELAY_SETTINGS:
            value = getattr(self, name, None)
            if value is None:
                value = getattr(self.drive, name)
            if isinstance(value, tuple):
                value = list(value)
            yield from ("-p", f"{name}:={str(value).lower()}")
