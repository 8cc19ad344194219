"""Runs the foraging world as its own process.

For example::

    python -m foraging_world.world_main --ros-args -r __ns:=/world -p parameters.foragers:=100

The figures of the world are ROS parameters; see `foraging_world.parameters`.
"""

from __future__ import annotations

from rclpy.node import Node

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_world import run_world
from hitab_world.node.ros_parameters import declare_parameters


def make_world(node: Node, seed: int) -> ForagingWorld:
    """Create the world that the node's parameters describe.

    Raises:
        HitabError: if a figure is invalid, or there is no room for all boxes and obstacles.
    """
    return ForagingWorld(declare_parameters(node, ForagingParameters), seed)


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
