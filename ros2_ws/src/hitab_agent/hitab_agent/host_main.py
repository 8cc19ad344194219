"""Runs many agents in one process, each a node of its own.

For example::

    python -m hitab_agent.host_main --ros-args -p agents:="[ant_1, ant_2]" -p domain:=keepaway

All parameters of an agent (see `hitab_agent.settings`) are given once, for all. Where agents
differ, a file says which to run and how, in JSON::

    python -m hitab_agent.host_main --ros-args -p roster:=host_1.json

    [{"name": "ant_1", "parameters": {"domain": "foraging", "commander": "chief"}},
     {"name": "chief", "node": "hitab_commander.commander_node:CommanderNode",
      "parameters": {"domain": "squad.yaml", "subordinates": ["ant_1", "ant_2"]}}]
"""

from __future__ import annotations

import gc
import sys
import uuid

from hitab_msgs.msg import AgentStatus
from rclpy.parameter import Parameter

from hitab_agent.host.host_shared import shared_on_host
from hitab_agent.host.roster import read_roster
from hitab_core import HitabError
from hitab_ros import Spinner, make_node, refuse_second_of_name, run

NO_TYPE_DESCRIPTIONS = Parameter("start_type_description_service", value=False)
"""A service that every node has, and nobody uses."""

GARBAGE = (10_000, 20, 100)
"""New objects until the youngest are searched for garbage; searches until older ones are."""


def start(spinning: Spinner) -> None:
    """Make all agents that the command line describes."""
    host = make_node("host")
    spinning.executor.add_node(host)
    entries = read_roster(host)
    names = [entry.name for entry in entries]
    doubles = sorted({name for name in names if names.count(name) > 1})
    if doubles:
        raise HitabError(f"the host was given {', '.join(doubles)} twice")
    namespace = host.get_namespace().rstrip("/")
    swarm = host.get_parameter("swarm").value  # of all its agents
    # A node that has the topics of the host, in a namespace of its own.
    desk = make_node("host", namespace=f"{namespace}/host_{uuid.uuid4().hex[:8]}")
    spinning.executor.add_node(desk)
    shared = shared_on_host(desk, len(entries), swarm)
    nodes = []
    for entry in entries:
        parameters = {"swarm": swarm, **entry.parameters}
        node = entry.node(
            namespace=f"{namespace}/{entry.name}",
            parameter_overrides=[
                NO_TYPE_DESCRIPTIONS,
                *(Parameter(name, value=value) for name, value in parameters.items()),
            ],
            use_global_arguments=False,
            shared=shared,
        )
        spinning.executor.add_node(node)
        nodes.append(node)
    refuse_second_of_name(spinning, nodes, AgentStatus)
    for node in nodes:
        node.join()
    for link in shared.links.values():
        link.announce()
    # What was made so far stays: searching it for garbage would take longer than a cycle. What a
    # cycle leaves behind goes by itself, but for errors: there is no hurry to look for those.
    gc.collect()
    gc.freeze()
    gc.set_threshold(*GARBAGE)


def main() -> None:
    """Run until stopped."""
    sys.exit(run(start))


if __name__ == "__main__":
    main()
