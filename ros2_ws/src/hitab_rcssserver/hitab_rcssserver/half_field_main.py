"""Runs half-field attack on an rcssserver, as `keepaway_main` runs keepaway."""

from __future__ import annotations

from rclpy.node import Node

from half_field_world.game import rules_of
from half_field_world.parameters import HalfFieldParameters
from hitab_rcssserver.rcss_world import RcssWorld, patience_of
from hitab_rcssserver.server_settings import ServerSettings
from hitab_world import run_world
from hitab_world.node.ros_parameters import declare_parameters


def make_world(node: Node, seed: int) -> RcssWorld:
    """Create the world described by the node's parameters; the server may start later.

    A node calls `idle` until the server is there. Without ROS, `reset` waits for it.

    Raises:
        HitabError: if a parameter is invalid.
    """
    server, parameters = declare_parameters(node, ServerSettings, HalfFieldParameters)
    return RcssWorld(server, parameters, seed, rules_of(parameters), patience=patience_of(node))


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
