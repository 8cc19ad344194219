"""Runs many agents in one process, each a node of its own.

For example::

    python -m hitab_agent.host_main --ros-args -p agents:="[ant_1, ant_2]" -p domain:=keepaway

All parameters of an agent (see `hitab_agent.settings`) are given once, for all.
"""

from __future__ import annotations

import sys

from hitab_msgs.msg import AgentStatus
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.parameter import Parameter

from hitab_agent.agent_node import AgentNode
from hitab_agent.settings import AgentSettings
from hitab_core.errors import HitabError
from hitab_ros.name_guard import refuse_second_of_name
from hitab_ros.spinning import Spinner, make_node, run


def start(spinning: Spinner) -> None:
    """Make all agents that the command line describes."""
    host = make_node("host")
    spinning.executor.add_node(host)
    names = host.declare_parameter(
        "agents",
        Parameter.Type.STRING_ARRAY,
        ParameterDescriptor(description="names of the agents to run here"),
    ).value
    if not names:
        raise HitabError('the host was given no agents; give it -p agents:="[a, b]"')
    doubles = sorted({name for name in names if names.count(name) > 1})
    if doubles:
        raise HitabError(f"the host was given {', '.join(doubles)} twice")
    settings = AgentSettings.declare(host)
    overrides = [
        Parameter(name, value=getattr(settings, name)) for name in AgentSettings.__slots__
    ]
    swarm = host.get_namespace().rstrip("/")
    nodes = []
    for name in names:
        node = AgentNode(
            namespace=f"{swarm}/{name}",
            parameter_overrides=overrides,
            use_global_arguments=False,
        )
        spinning.executor.add_node(node)
        nodes.append(node)
    refuse_second_of_name(spinning, nodes, AgentStatus)
    for node in nodes:
        node.join()


def main() -> None:
    """Run until told to stop."""
    sys.exit(run(start))


if __name__ == "__main__":
    main()
