"""Runs keepaway on an rcssserver as the world of a swarm, in a process of its own.

For example, with a server on this machine::

    ros2 run keepaway_world rcss_world --ros-args -r __ns:=/world -p pace:=lockstep

Where the server is and who plays the takers are parameters, such as
``-p parameters.host:=10.0.0.7``; so are the figures of the game that are not the server's to
decide, such as ``-p parameters.taker_speed:=1.0``. See docs/rcssserver.md.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import MISSING, fields
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from hitab_core.errors import HitabError
from hitab_ros.spinning import Loop, Spinner, run
from hitab_world.world_node import run_world
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.rcss.link import ServerSettings
from keepaway_world.rcss.rcss_world import RcssWorld
from keepaway_world.world_main import PREFIX


def make_world(node: Node, seed: int) -> RcssWorld:
    """Make the world that the node's parameters describe; the server may start later.

    Raises:
        HitabError: if a parameter cannot be.
    """
    server = _declared(node, ServerSettings)
    figures = _declared(node, KeepawayParameters)
    known = {PREFIX + name for name in (*server, *figures)}
    for name in node.get_parameters_by_prefix("parameters"):
        if PREFIX + name not in known:
            raise HitabError(f'neither the server nor the game has a parameter "{name}"')
    try:
        return RcssWorld(ServerSettings(**server), KeepawayParameters(**figures), seed)
    except ValueError as error:
        raise HitabError(str(error)) from error


def _declared(node: Node, settings: type[Any]) -> dict[str, Any]:
    """Declare a dataclass's fields as parameters and return their values."""
    values = {}
    for figure in fields(settings):
        default = figure.default if figure.default is not MISSING else None
        values[figure.name] = node.declare_parameter(
            PREFIX + figure.name, default, ParameterDescriptor(read_only=True)
        ).value
    return values


def _start(spinning: Spinner) -> Loop:
    worlds: list[RcssWorld] = []

    def make(node: Node, seed: int) -> RcssWorld:
        worlds.append(make_world(node, seed))
        return worlds[0]

    loop: Callable[[Spinner], int] = run_world(make, spinning)

    def run_and_leave(spinning: Spinner) -> int:
        try:
            return loop(spinning)
        finally:
            worlds[0].close()  # else the server would wait for our players

    return run_and_leave


def main() -> None:
    """Run until told to stop."""
    sys.exit(run(_start))


if __name__ == "__main__":
    main()
