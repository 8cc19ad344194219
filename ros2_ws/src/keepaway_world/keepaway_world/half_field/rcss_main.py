"""Runs half-field attack on an rcssserver, as `keepaway_world.rcss.rcss_main` runs keepaway."""

from __future__ import annotations

from rclpy.node import Node

from hitab_world import run_world
from hitab_world.figures import declare_figures
from keepaway_world.half_field.game import rules_of
from keepaway_world.half_field.parameters import HalfFieldParameters
from keepaway_world.rcss.rcss_world import RcssWorld
from keepaway_world.rcss.server_settings import ServerSettings


def make_world(node: Node, seed: int) -> RcssWorld:
    """Create the world described by the node's parameters; the server may start later.

    Raises:
        HitabError: if a parameter is invalid.
    """
    server, parameters = declare_figures(node, ServerSettings, HalfFieldParameters)
    return RcssWorld(server, parameters, seed, rules_of(parameters))


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
