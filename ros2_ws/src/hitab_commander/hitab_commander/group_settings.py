"""The parameters of a commander's node that other agents do not have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from hitab_core import HitabError, quantity
from hitab_ros import names


@dataclass(frozen=True, slots=True)
class GroupSettings:
    """The group of a commander.

    Attributes:
        roles: of the subordinates, by name.
        asks_position: whether subordinates report their positions.
    """

    roles: dict[str, str]
    asks_position: bool

    @classmethod
    def declare(cls, node: Node) -> GroupSettings:
        """Declare the parameters and return their values.

        Raises:
            HitabError: if there are no subordinates, or the number of roles differs from theirs.
        """
        commander = names.own_name(node)
        strings = Parameter.Type.STRING_ARRAY
        subordinates = _parameter(node, "subordinates", strings, "names of the subordinates")
        if not subordinates:
            raise HitabError(
                f'the commander {commander} has no subordinates; give it -p subordinates:="[a, b]"'
            )
        roles = _parameter(node, "roles", [""], "roles of the subordinates, in the same order")
        if list(roles) == [""]:
            roles = [""] * len(subordinates)
        if len(roles) != len(subordinates) or len(set(subordinates)) != len(subordinates):
            raise HitabError(
                f"the commander {commander} was given "
                f"{quantity(len(subordinates), 'subordinate')} and "
                f"{quantity(len(roles), 'role')}; it needs a role for each, "
                "and each subordinate once"
            )
        asks = _parameter(node, "asks_position", False, "have subordinates report their positions")
        return cls(dict(zip(subordinates, roles, strict=True)), asks)


def _parameter(node: Node, name: str, default: Any, description: str) -> Any:
    return node.declare_parameter(
        name, default, ParameterDescriptor(description=description, read_only=True)
    ).value
