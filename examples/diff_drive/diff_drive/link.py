"""The robot's side of an agent: standard messages in, velocity commands out, at a fixed rate."""

from __future__ import annotations

import math

from geometry_msgs.msg import Twist
from hitab_msgs.msg import Percept
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from rclpy.time import Time
from sensor_msgs.msg import LaserScan

from hitab_agent import OnPercept

AHEAD = math.radians(15.0)  # to either side; wide enough for the hull at half a metre
SILENT = [math.nan] * 3


class DiffDriveLink:
    """Ticks the agent at a fixed rate with what the sensors said last, and drives as it says.

    Topics are relative to the agent's namespace: ``odom``, ``scan``, ``cmd_vel``. The ROS
    parameters ``rate`` and ``patience`` are the link's own.
    """

    def __init__(self, node: Node, world: str, on_percept: OnPercept) -> None:
        self._on_percept = on_percept
        self._clock = node.get_clock()
        rate = _parameter(node, "rate", 10.0, "Hz; how often the agent decides and acts")
        self._patience = _parameter(
            node, "patience", 0.5, "s; a sensor that says nothing for longer has no value"
        )
        self._pose = self._ranges = SILENT
        self._pose_time = self._ranges_time = self._clock.now()
        self._cycle = 0
        node.create_subscription(Odometry, "odom", self._on_odometry, qos_profile_sensor_data)
        node.create_subscription(LaserScan, "scan", self._on_scan, qos_profile_sensor_data)
        self._velocities = node.create_publisher(Twist, "cmd_vel", 10)
        node.create_timer(1.0 / rate, self._tick)

    def _on_odometry(self, odometry: Odometry) -> None:
        pose = odometry.pose.pose
        # The robot stays on the floor: its heading is the rotation about z.
        heading = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        self._pose = [pose.position.x, pose.position.y, heading]
        self._pose_time = self._clock.now()

    def _on_scan(self, scan: LaserScan) -> None:
        # REP 117: -inf is too near to be measured, inf too far, and NaN was not measured at all.
        seen = [
            (
                min(max(distance, scan.range_min), scan.range_max),
                math.remainder(scan.angle_min + i * scan.angle_increment, math.tau),
            )
            for i, distance in enumerate(scan.ranges)
            if not math.isnan(distance)
        ]
        ahead = [distance for distance, angle in seen if abs(angle) <= AHEAD]
        self._ranges = [min(ahead, default=math.nan), *min(seen, default=(math.nan, math.nan))]
        self._ranges_time = self._clock.now()

    def _fresh(self, values: list[float], since: Time) -> list[float]:
        """Return values, NaN if they are old: then the agent does nothing that needs them."""
        age = (self._clock.now() - since).nanoseconds * 1e-9
        return values if age <= self._patience else SILENT

    def _tick(self) -> None:
        self._cycle += 1
        percept = Percept(
            stamp=self._clock.now().to_msg(),
            sequence=self._cycle,
            cycle=self._cycle,
            values=[
                *self._fresh(self._pose, self._pose_time),
                *self._fresh(self._ranges, self._ranges_time),
            ],
        )
        action, _ = self._on_percept(percept)
        velocity = Twist()
        if action:  # nothing if something was wrong: then the robot stands still
            velocity.linear.x, velocity.angular.z = action
        self._velocities.publish(velocity)

    def close(self) -> None:
        """Bring the robot to rest before the agent ends."""
        self._velocities.publish(Twist())
        self._velocities.wait_for_all_acked(Duration(seconds=0.5))


def _parameter(node: Node, name: str, default: float, description: str) -> float:
    limits = FloatingPointRange(from_value=0.01, to_value=1000.0)
    descriptor = ParameterDescriptor(
        description=description, read_only=True, floating_point_range=[limits]
    )
    value: float = node.declare_parameter(name, default, descriptor).value
    return value
