"""Runs keepaway on an rcssserver as the world of a swarm, in its own process.

For example, with a server on this machine::

    ros2 run hitab_rcssserver rcss_world --ros-args -r __ns:=/world -p pace:=lockstep

The server's address and the choice of takers are parameters, such as
``-p parameters.host:=10.0.0.7``; so are the parameters of the game that the server does not
decide, such as ``-p parameters.taker_speed:=1.0``. See docs/rcssserver.md.
"""

from __future__ import annotations

from rclpy.node import Node

from hitab_rcssserver.rcss_world import RcssWorld, patience_of
from hitab_rcssserver.server_settings import ServerSettings
from hitab_world import run_world
from hitab_world.node.ros_parameters import declare_parameters
from keepaway_world.parameters import KeepawayParameters


def make_world(node: Node, seed: int) -> RcssWorld:
    """Create the world described by the node's parameters; the server may start later.

    A node calls `idle` until the server is there. Without ROS, `reset` waits for it.

    Raises:
        HitabError: if a parameter is invalid.
    """
    server, parameters = declare_parameters(node, ServerSettings, KeepawayParameters)
    return RcssWorld(server, parameters, seed, patience=patience_of(node))


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
