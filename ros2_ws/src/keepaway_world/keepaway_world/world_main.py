"""Runs the keepaway world in its own process.

For example::

    python -m keepaway_world.world_main --ros-args -r __ns:=/world -p pace:=lockstep

The game's parameters can be set as well, such as ``-p parameters.taker_speed:=1.0``; see
`keepaway_world.parameters`.
"""

from __future__ import annotations

from rclpy.node import Node

from hitab_world import run_world
from hitab_world.node.ros_parameters import declare_parameters
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld


def make_world(node: Node, seed: int) -> KeepawayWorld:
    """Create the world described by the node's parameters.

    Raises:
        HitabError: if a parameter of the game is invalid.
    """
    return KeepawayWorld(declare_parameters(node, KeepawayParameters), seed)


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
