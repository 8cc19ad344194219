"""The parameters of an agent's node."""

from __future__ import annotations

from dataclasses import dataclass, field, fields
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

_SECONDS = FloatingPointRange(from_value=0.0, to_value=3600.0)
_WHOLE = IntegerRange(from_value=0, to_value=2**63 - 1, step=1)


def _parameter(default: Any, description: str) -> Any:
    return field(default=default, metadata={"description": description})


@dataclass(frozen=True)
class AgentSettings:
    """How one agent is set up; each field is a ROS parameter."""

    domain: str = _parameter("", "name of an installed domain: what the agent can do and perceive")
    without: tuple[str, ...] = _parameter(
        (), "hand-written automata of the domain that are taken out, such as [GotoBall]"
    )
    library: str = _parameter(
        "", "folder of trained behaviors; empty: the folder library in the agent's state_dir"
    )
    state_dir: str = _parameter(
        "~/.local/state/hitab",
        "folder with one per agent, where an unfinished training survives a crash",
    )
    behavior: str = _parameter(
        "", "what to perform at startup, such as GoTo(ball); empty: nothing"
    )
    world: str = _parameter("world", "name of the world's node, which sends the percepts")
    seed: int = _parameter(0, "of the agent's random numbers, until a world sets one")
    most_probable: bool = _parameter(
        False, "take the most probable next state instead of drawing from the distribution"
    )
    commander: str = _parameter(
        "", "name of the commander whose orders it obeys; empty: it has none"
    )
    role: str = _parameter("", "in its commander's group, for orders that differ by role")
    services_on_demand: bool = _parameter(
        False, "create the services when a client asks, as a host's agents do"
    )
    auto_rearm: bool = _parameter(
        False, "act again by itself when what stopped its robot is over: a risk"
    )
    swarm: str = _parameter("", "identity of its swarm; empty: none, and nothing to resume")
    offer_actions: bool = _parameter(
        False, "offer its behaviors as one ROS action, perform_until_done"
    )
    action_timeout: float = _parameter(
        2.0, "s; how long to wait for the server of an action, and for its answers"
    )
    action_patience: float = _parameter(
        2.0, "s without a tick after which an action's goal is canceled; 0: never"
    )

    @classmethod
    def declare(cls, node: Node) -> AgentSettings:
        """Declare the parameters and return their values."""
        return cls(**{one.name: _declared(node, one) for one in fields(cls)})


def _declared(node: Node, setting: Any) -> Any:
    default, is_list = setting.default, isinstance(setting.default, tuple)
    descriptor = ParameterDescriptor(read_only=True, **setting.metadata)
    if isinstance(default, float):
        descriptor.floating_point_range = [_SECONDS]
    elif type(default) is int:
        descriptor.integer_range = [_WHOLE]
    # The type of an empty list could not be seen from it.
    value = node.declare_parameter(setting.name, [""] if is_list else default, descriptor).value
    return tuple(filter(None, value)) if is_list else value
