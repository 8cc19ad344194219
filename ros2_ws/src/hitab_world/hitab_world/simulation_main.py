"""Runs a world in one file as its own process; see `hitab_world.simulating.simulation`.

For example::

    python -m hitab_world.simulation_main --ros-args -r __ns:=/world -p parameters.file:=maze.py
"""

from __future__ import annotations

from rclpy.node import Node

from hitab_world.node.ros_parameters import declare_parameters
from hitab_world.node.world_node import run_world
from hitab_world.simulating.simulation import SimulationParameters, SimulationWorld


def make_world(node: Node, seed: int) -> SimulationWorld:
    """Create the world in the file that the node's parameters name.

    Raises:
        HitabError: if the file has no simulation, or its simulation cannot begin an episode.
    """
    return SimulationWorld(declare_parameters(node, SimulationParameters), seed)


def main() -> None:
    """Run until stopped."""
    run_world(make_world)


if __name__ == "__main__":
    main()
