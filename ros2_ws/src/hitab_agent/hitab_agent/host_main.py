"""Runs many agents in one process, each as its own node.

For example::

    python -m hitab_agent.host_main --ros-args -p roster:=host_1.json

A JSON file lists the agents with their parameters (see `hitab_agent.node.settings`)::

    [{"name": "ant_1", "parameters": {"domain": "foraging", "commander": "chief"},
      "remap": {"cmd_vel": "/base_1/cmd_vel"}},
     {"name": "chief", "node": "hitab_commander.commander_node:CommanderNode",
      "parameters": {"domain": "squad.yaml", "subordinates": ["ant_1", "ant_2"]}}]
"""

from __future__ import annotations

import gc
import sys

from hitab_msgs.msg import AgentStatus
from rcl_interfaces.msg import ParameterDescriptor

from hitab_agent.host.roster import read_roster
from hitab_agent.host_resources import HostResources
from hitab_ros import (
    Spinner,
    check_name_is_free,
    give_signs_of_life,
    make_node,
    names,
    run,
)

GC_THRESHOLDS = (10_000, 20, 100)
"""Thresholds for `gc.set_threshold`: new objects per collection, then collections of a generation
per collection of the next older one."""


ALL_ENDPOINTS = ParameterDescriptor(
    description="open all topics and services of the agents at once, not when somebody asks"
)


def start(spinning: Spinner) -> None:
    """Create all agents of the roster that the command line names."""
    gc.disable()  # what the start makes stays, so collecting over it would be in vain
    host = make_node("host")
    spinning.executor.add_node(host)
    entries = read_roster(host)
    namespace = host.get_namespace().rstrip("/")
    swarm = host.declare_parameter("swarm", "").value  # all agents get it
    machine = host.declare_parameter("machine", "").value
    # The command line names the namespace around the host and its agents, so the host's topics
    # need a node of their own below it. The name of the first agent makes that node's namespace
    # unique in the swarm, and the same in each run.
    desk = make_node(
        "host",
        namespace=f"{namespace}/{names.of_host(entries[0].name)}",
        use_global_arguments=False,
    )
    spinning.executor.add_node(desk)
    on_demand = not host.declare_parameter("all_endpoints", False, ALL_ENDPOINTS).value
    shared = HostResources(desk, is_host=True, on_demand=on_demand, swarm=swarm, machine=machine)
    nodes = [entry.create(namespace, swarm, shared) for entry in entries]
    for node in nodes:
        spinning.executor.add_node(node)
    check_name_is_free(spinning, nodes, AgentStatus, observer=desk)
    for node in nodes:
        node.join()
    for link in shared.links.values():
        link.listen()
    shared.publish_roster()
    give_signs_of_life(desk, swarm, shared.signs.fill)
    # The objects made so far stay, and collecting over them would take longer than a cycle.
    # Reference counting frees the objects of a cycle; only errors leave reference cycles, whose
    # collection is not urgent.
    gc.collect()
    gc.freeze()
    gc.set_threshold(*GC_THRESHOLDS)
    gc.enable()


def main() -> None:
    """Run until stopped."""
    sys.exit(run(start))


if __name__ == "__main__":
    main()
