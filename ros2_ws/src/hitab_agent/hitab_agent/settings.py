"""The parameters of an agent's node."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.node import Node

DESCRIPTIONS = {
    "domain": "name of an installed domain: what the agent can do and perceive",
    "without": "hand-written automata of the domain that are taken out, such as [GotoBall]",
    "library": "folder of trained behaviors; empty: the folder library in the agent's state_dir",
    "state_dir": "folder with one per agent, where an unfinished training survives a crash",
    "behavior": "what to perform at startup, such as GoTo(ball); empty: nothing",
    "world": "name of the world's node, which sends the percepts",
    "seed": "of the agent's random numbers, until a world sets one",
    "commander": "name of the commander whose orders it obeys; empty: it has none",
    "role": "in its commander's group, for orders that differ by role",
    "services_on_demand": "create the services when a client asks, as a host's agents do",
    "auto_rearm": "act again by itself when what stopped its robot is over: a risk",
    "swarm": "identity of its swarm; empty: none, and nothing to resume",
    "offer_actions": "offer its behaviors as one ROS action, perform_until_done",
    "action_timeout": "s; how long to wait for the server of an action, and for its answers",
    "action_patience": "s without a tick after which an action's goal is canceled; 0: never",
    "most_probable": "take the most probable next state instead of drawing from the distribution",
}


@dataclass(frozen=True, slots=True)
class AgentSettings:
    """How one agent is set up; each field is a ROS parameter, described above."""

    domain: str = ""
    without: tuple[str, ...] = ()
    library: str = ""
    state_dir: str = "~/.local/state/hitab"
    behavior: str = ""
    world: str = "world"
    seed: int = 0
    most_probable: bool = False
    commander: str = ""
    role: str = ""
    services_on_demand: bool = False
    auto_rearm: bool = False
    swarm: str = ""
    offer_actions: bool = False
    action_timeout: float = 2.0
    action_patience: float = 2.0

    @classmethod
    def declare(cls, node: Node) -> AgentSettings:
        """Declare the parameters and return their values."""
        values: dict[str, Any] = {}
        for setting in fields(cls):
            descriptor = ParameterDescriptor(
                description=DESCRIPTIONS[setting.name], read_only=True
            )
            if setting.name == "seed":
                descriptor.integer_range = [IntegerRange(from_value=0, to_value=2**63 - 1, step=1)]
            if isinstance(setting.default, float):
                limits = FloatingPointRange(from_value=0.0, to_value=3600.0)
                descriptor.floating_point_range = [limits]
            is_list = isinstance(setting.default, tuple)
            # The type of an empty list could not be seen from it.
            default = [""] if is_list else setting.default
            value = node.declare_parameter(setting.name, default, descriptor).value
            values[setting.name] = tuple(filter(None, value)) if is_list else value
        return cls(**values)
