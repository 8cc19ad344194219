"""Starts a controller whose velocities pass the robot's velocity relay.

ros2 launch examples/nav2/controller.launch.py namespace:=robot_1
"""

import sys
from pathlib import Path

from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return the robot's namespace as an argument, and the controller."""
    return LaunchDescription(
        [
            DeclareLaunchArgument("namespace", default_value="robot_1"),
            Node(
                executable=sys.executable,
                arguments=[str(Path(__file__).with_name("controller.py"))],
                namespace=LaunchConfiguration("namespace"),
                remappings=[("cmd_vel", "cmd_vel_agent")],
            ),
        ]
    )
