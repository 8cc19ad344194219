"""Stands for Nav2's controller: drives a robot in a circle, by `TwistStamped` on ``cmd_vel``.

python controller.py --ros-args -r __ns:=/robot_1 -r cmd_vel:=cmd_vel_agent
"""

from __future__ import annotations

import rclpy
from geometry_msgs.msg import TwistStamped
from rclpy.executors import ExternalShutdownException


def main() -> None:
    """Publish twenty velocities a second until told to stop."""
    rclpy.init()
    node = rclpy.create_node("controller_server")
    publisher = node.create_publisher(TwistStamped, "cmd_vel", 10)

    def publish() -> None:
        velocity = TwistStamped()
        velocity.header.stamp = node.get_clock().now().to_msg()
        velocity.twist.linear.x = 0.2
        velocity.twist.angular.z = 0.5
        publisher.publish(velocity)

    node.create_timer(0.05, publish)
    try:
        rclpy.spin(node)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        node.destroy_node()
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
