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
        roles: the subordinates' roles, by name.
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
        strings = Parameter.Type.STRING_ARRAY
        subordinates = _parameter(node, "subordinates", strings, "names of the subordinates") or []
        roles = _parameter(node, "roles", [""], "roles of the subordinates, in the same order")
        if list(roles) == [""]:
            roles = [""] * len(subordinates)
        if not subordinates or not len(subordinates) == len(roles) == len(set(subordinates)):
            raise HitabError(
                f"the commander {names.own_name(node)} was given "
                f"{quantity(len(subordinates), 'subordinate')} and "
                f"{quantity(len(roles), 'role')}; name each subordinate once, as in -p "
                'subordinates:="[a, b]", and give a role to each or to none'
            )
        asks = _parameter(node, "asks_position", False, "have subordinates report their positions")
        return cls(dict(zip(subordinates, roles, strict=True)), asks)


def _parameter(node: Node, name: str, default: Any, description: str) -> Any:
    descriptor = ParameterDescriptor(description=description, read_only=True)
    return node.declare_parameter(name, default, descriptor).value
