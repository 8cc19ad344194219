"""Runs the keepaway world as a process of its own.

For example::

    python -m keepaway_world.world_main --ros-args -r __ns:=/world -p pace:=lockstep

Figures of the game are parameters too, such as ``-p parameters.taker_speed:=1.0``; see
`keepaway_world.parameters`.
"""

from __future__ import annotations

import sys
from dataclasses import MISSING, fields
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from hitab_core.errors import HitabError
from hitab_ros.spinning import run
from hitab_world.world_node import run_world
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.world import KeepawayWorld

PREFIX = "parameters."


def make_world(node: Node, seed: int) -> KeepawayWorld:
    """Make the world that the node's parameters describe.

    Raises:
        HitabError: if a figure of the game cannot be.
    """
    values = declared_figures(node, KeepawayParameters)
    try:
        return KeepawayWorld(KeepawayParameters(**values), seed)
    except ValueError as error:
        raise HitabError(str(error)) from error


def declared_figures(node: Node, *settings: type[Any]) -> dict[str, Any]:
    """Declare the fields of dataclasses as parameters of the node and return their values.

    Raises:
        HitabError: if the node was given another figure.
    """
    values = {}
    for figure in (figure for kind in settings for figure in fields(kind)):
        default = figure.default if figure.default is not MISSING else None
        values[figure.name] = node.declare_parameter(
            PREFIX + figure.name, default, ParameterDescriptor(read_only=True)
        ).value
    known = {PREFIX + name for name in values}
    for name in node.get_parameters_by_prefix("parameters"):
        if PREFIX + name not in known:
            raise HitabError(f'the game has no figure "{name}"')
    return values


def main() -> None:
    """Run until told to stop."""
    sys.exit(run(lambda spinning: run_world(make_world, spinning)))


if __name__ == "__main__":
    main()
