"""The roster of a host: the file that lists its agents."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from hitab_agent.host_resources import HostResources
from hitab_agent.node.agent_node import AgentNode
from hitab_core import HitabError
from hitab_ros import NO_TYPE_DESCRIPTIONS


@dataclass(frozen=True)
class Entry:
    """An agent of the roster: its name, its node's class, and the node's parameters and remaps."""

    name: str
    node: type[AgentNode]
    parameters: Mapping[str, Any]
    remap: Mapping[str, str] = field(default_factory=dict)

    def create(self, namespace: str, swarm: str, shared: HostResources) -> AgentNode:
        """Return the agent's node, which has not joined.

        Args:
            namespace: the swarm's namespace.
            swarm: identity of the swarm, unless the roster gives the agent another one.
            shared: the host's resources.
        """
        parameters = {"swarm": swarm, **self.parameters}
        return self.node(
            namespace=f"{namespace}/{self.name}",
            parameter_overrides=[
                NO_TYPE_DESCRIPTIONS,
                *(Parameter(name, value=value) for name, value in parameters.items()),
            ],
            use_global_arguments=False,
            cli_args=_renaming(self.remap),
            shared=shared,
        )


def read_roster(host: Node) -> list[Entry]:
    """Return the agents in the file that the host's parameter ``roster`` names.

    Raises:
        HitabError: if there is no such file, or it cannot be used.
    """
    description = ParameterDescriptor(description="file that lists the agents to run")
    path = Path(host.declare_parameter("roster", "", description).value)
    try:
        entries = [_entry(**entry) for entry in json.loads(path.read_text(encoding="utf-8"))]
        names = [entry.name for entry in entries]
        if not names or len({*names}) < len(names):
            raise ValueError("it must name at least one agent, and each once")
        return entries
    except (OSError, ValueError, KeyError, TypeError, AttributeError, ImportError) as error:
        raise HitabError(
            f"{path}: not a roster of agents: {type(error).__name__}: {error}; for the format see "
            "`python -m pydoc hitab_agent.host_main`"
        ) from None


def _entry(
    name: str,
    node: str = "",
    parameters: Mapping[str, Any] | None = None,
    remap: Mapping[str, str] | None = None,
) -> Entry:
    if not isinstance(remap, dict | None):
        raise TypeError(f"the remappings {remap!r} must be a mapping from name to name")
    if not isinstance(name, str) or not isinstance(parameters, dict | None):
        raise TypeError(f"{name!r} must be a name, and its parameters {parameters!r} a mapping")
    return Entry(name, _node_class(node), parameters or {}, remap or {})


def _node_class(name: str) -> type[AgentNode]:
    if not name:
        return AgentNode
    module, _, attribute = name.partition(":")
    found = getattr(import_module(module), attribute)
    if not (isinstance(found, type) and issubclass(found, AgentNode)):
        raise TypeError(f'"{name}" is not a subclass of AgentNode')
    return found


def _renaming(remap: Mapping[str, str]) -> list[str]:
    """Return the command-line arguments for a node's remappings."""
    rules = [part for name, other in remap.items() for part in ("-r", f"{name}:={other}")]
    return ["--ros-args", *rules] if rules else []
