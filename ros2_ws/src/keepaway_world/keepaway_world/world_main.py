"""Runs the keepaway world as a process of its own.

For example::

    python -m keepaway_world.world_main --ros-args -r __ns:=/world -p pace:=lockstep

Figures of the game are parameters too, such as ``-p parameters.taker_speed:=1.0``; see
`keepaway_world.parameters`.
"""

from __future__ import annotations

import sys

from rclpy.node import Node

from hitab_ros import run
from hitab_world import run_world
from hitab_world.figures import declare_figures
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld


def make_world(node: Node, seed: int) -> KeepawayWorld:
    """Make the world that the node's parameters describe.

    Raises:
        HitabError: if a figure of the game cannot be.
    """
    return KeepawayWorld(declare_figures(node, KeepawayParameters), seed)


def main() -> None:
    """Run until told to stop."""
    sys.exit(run(lambda spinning: run_world(make_world, spinning)))


if __name__ == "__main__":
    main()
