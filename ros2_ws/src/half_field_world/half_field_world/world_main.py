"""Runs half-field attack in its own process, as `keepaway_world.world_main` runs keepaway."""

from __future__ import annotations

from rclpy.node import Node

from half_field_world.game import half_field
from half_field_world.parameters import HalfFieldParameters
from hitab_world import run_world
from hitab_world.node.ros_parameters import declare_parameters
from keepaway_world.world import KeepawayWorld


def make_world(node: Node, seed: int) -> KeepawayWorld:
    """Create the world described by the node's parameters.

    Raises:
        HitabError: if a parameter of the game is invalid.
    """
    return half_field(declare_parameters(node, HalfFieldParameters), seed)


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
