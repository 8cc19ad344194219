"""Runs a world in one file as its own process; see `hitab_world.simulation`.

For example::

    python -m hitab_world.simulation_main --ros-args -r __ns:=/world -p parameters.file:=maze.py
"""

from __future__ import annotations

from rclpy.node import Node

from hitab_world.ros_parameters import declare_parameters
from hitab_world.simulation import SimulationParameters, SimulationWorld
from hitab_world.world_node import run_world


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
