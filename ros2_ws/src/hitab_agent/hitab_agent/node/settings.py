"""The parameters of an agent's node."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

from hitab_core import HitabError

_SECONDS = FloatingPointRange(from_value=0.0, to_value=3600.0)
_WHOLE = IntegerRange(from_value=0, to_value=2**63 - 1, step=1)


def _is(default: Any, description: str) -> Any:
    return field(default=default, metadata={"description": description})


@dataclass(frozen=True)
class AgentParameters:
    """The parameters of one agent; each field is a ROS parameter."""

    domain: str = _is("", "name of an installed domain: behaviors, features, targets")
    library: str = _is("", "folder of trained behaviors; empty for one in state_dir")
    state_dir: str = _is(
        "~/.local/state/hitab",
        "folder of all agents' state; an unfinished training in it survives a crash",
    )
    behavior: str = _is("", "behavior to perform at startup, such as GoTo(ball); empty for none")
    world: str = _is("world", "name of the world's node, which sends the percepts")
    seed: int = _is(0, "seed of the agent's random numbers, until a world sets one")
    most_probable: bool = _is(False, "take the most probable next state instead of drawing one")
    commander: str = _is("", "name of the agent's commander; empty for none")
    role: str = _is("", "the agent's role, for orders that differ by role")
    services_on_demand: bool = _is(False, "create the services only when a client appears")
    when_out_of_reach: str = _is("go_on", "go_on or halt while commander or operator is silent")
    out_of_reach_after: float = _is(5.0, "s of silence after which commander or operator are lost")
    superiors: Sequence[str] = _is(("",), "commanders above its own without whom it halts, too")
    auto_rearm: bool = _is(False, "act again without re-arming after a stop: a risk")
    swarm: str = _is("", "identity of the agent's swarm; empty for none")
    offer_actions: bool = _is(False, "offer the action perform_until_done")
    action_timeout: float = _is(2.0, "s to wait for an action's server and for its answers")
    action_patience: float = _is(2.0, "s without a tick until goals are canceled; 0 for no limit")

    def __post_init__(self) -> None:
        if (given := self.when_out_of_reach) not in ("go_on", "halt"):
            raise HitabError(f'when_out_of_reach is "{given}"; it must be go_on or halt')

    @classmethod
    def declare(cls, node: Node) -> AgentParameters:
        """Declare the parameters and return their values."""
        return cls(**{one.name: _declared(node, one) for one in fields(cls)})


def _declared(node: Node, setting: Any) -> Any:
    return node.declare_parameter(setting.name, setting.default, _descriptor(setting)).value


@cache  # as the nodes of a process are many, and their descriptors equal
def _descriptor(setting: Any) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(read_only=True, **setting.metadata)
    if isinstance(setting.default, float):
        descriptor.floating_point_range = [_SECONDS]
    elif type(setting.default) is int:
        descriptor.integer_range = [_WHOLE]
    return descriptor
