"""A robot for the desk: publishes odom and scan, obeys cmd_vel, in a room with a pillar.

It stands in for a robot's own driver and knows nothing of HiTAB. For example::

    python -m diff_drive.simulated_robot --ros-args -r __ns:=/robot_1

With the parameter ``enable_stamped_cmd_vel`` it takes `TwistStamped`, as robots with Jazzy do.
"""

from __future__ import annotations

import math

import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import LaserScan

LEFT, RIGHT, BOTTOM, TOP = -1.5, 2.5, -1.5, 1.5  # m: the room
PILLAR_X, PILLAR_Y, PILLAR_RADIUS = -0.9, 0.9, 0.2
HULL = 0.2  # m
PERIOD = 0.05  # s
BEAMS = 72
RANGE = 6.0  # m
PATIENCE = 0.5  # s: it stops when nobody has commanded it for longer, as real ones do


def distance(x: float, y: float, angle: float) -> float:
    """Return how far a ray runs until it meets a wall or the pillar."""
    dx, dy = math.cos(angle), math.sin(angle)
    to_wall_x = ((RIGHT if dx > 0 else LEFT) - x) / dx if dx else math.inf
    to_wall_y = ((TOP if dy > 0 else BOTTOM) - y) / dy if dy else math.inf
    nearest = min(to_wall_x, to_wall_y)
    along = (PILLAR_X - x) * dx + (PILLAR_Y - y) * dy
    beside = (PILLAR_X - x) * dy - (PILLAR_Y - y) * dx
    if along > 0 and abs(beside) < PILLAR_RADIUS:
        nearest = min(nearest, along - math.sqrt(PILLAR_RADIUS**2 - beside**2))
    return nearest


class SimulatedRobot(Node):
    """Moves as commanded, unless something is in the way."""

    def __init__(self) -> None:
        super().__init__("simulated_robot")
        self.x = self.y = self.heading = 0.0
        self.velocity = Twist()
        self.commanded = self.get_clock().now()
        self.odom = self.create_publisher(Odometry, "odom", 10)
        self.scan = self.create_publisher(LaserScan, "scan", qos_profile_sensor_data)
        if self.declare_parameter("enable_stamped_cmd_vel", False).value:
            self.create_subscription(
                TwistStamped, "cmd_vel", lambda message: self.obey(message.twist), 10
            )
        else:
            self.create_subscription(Twist, "cmd_vel", self.obey, 10)
        self.create_timer(PERIOD, self.step)

    def obey(self, velocity: Twist) -> None:
        """Take a command."""
        self.velocity = velocity
        self.commanded = self.get_clock().now()

    def step(self) -> None:
        """Move for one period and publish where that led and what is seen from there."""
        if (self.get_clock().now() - self.commanded).nanoseconds > PATIENCE * 1e9:
            self.velocity = Twist()
        self.heading += self.velocity.angular.z * PERIOD
        x = self.x + self.velocity.linear.x * math.cos(self.heading) * PERIOD
        y = self.y + self.velocity.linear.x * math.sin(self.heading) * PERIOD
        inside = LEFT + HULL < x < RIGHT - HULL and BOTTOM + HULL < y < TOP - HULL
        if inside and math.hypot(PILLAR_X - x, PILLAR_Y - y) > PILLAR_RADIUS + HULL:
            self.x, self.y = x, y
        self.tell()

    def tell(self) -> None:
        """Publish the odometry and a scan."""
        now = self.get_clock().now().to_msg()
        odometry = Odometry(child_frame_id="base_link")
        odometry.header.stamp = now
        odometry.header.frame_id = "odom"
        odometry.pose.pose.position.x = self.x
        odometry.pose.pose.position.y = self.y
        odometry.pose.pose.orientation.z = math.sin(self.heading / 2)
        odometry.pose.pose.orientation.w = math.cos(self.heading / 2)
        odometry.twist.twist = self.velocity
        self.odom.publish(odometry)
        step = math.tau / BEAMS
        scan = LaserScan(
            angle_min=-math.pi, angle_max=math.pi - step, angle_increment=step,
            range_min=0.05, range_max=RANGE, scan_time=PERIOD,
        )  # fmt: skip
        scan.header.stamp = now
        scan.header.frame_id = "base_link"
        scan.ranges = [
            distance(self.x, self.y, self.heading + scan.angle_min + i * step)
            for i in range(BEAMS)
        ]
        self.scan.publish(scan)


def main() -> None:
    """Run until told to stop."""
    rclpy.init()
    node = SimulatedRobot()
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RCLError:
        if rclpy.ok():
            raise  # otherwise the node was stopped while it published
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
