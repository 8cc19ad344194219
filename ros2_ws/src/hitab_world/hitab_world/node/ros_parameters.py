"""The parameters of a kind of world as ROS parameters, declared from their dataclass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import Field, fields
from types import SimpleNamespace
from typing import Any

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node
from rclpy.parameter import Parameter

from hitab_core import HitabError, has

PARAMETER_GROUP = "parameters"


class GivenParameters:
    """Parameters of a world without a node, for worlds that are made without ROS.

    Args:
        values: the given values, by name.
    """

    def __init__(self, values: Mapping[str, Any]) -> None:
        self._parameter_overrides = {f"{PARAMETER_GROUP}.{name}": v for name, v in values.items()}

    def declare_parameter(self, name: str, default: Any, *described: Any) -> Any:
        """Return an object whose ``value`` is the given value, or else the default."""
        return SimpleNamespace(value=self._parameter_overrides.get(name, default))


def declare_parameters(node: Node, *kinds: type[Any]) -> Any:
    """Return the world's parameters from those of a node, such as ``-p parameters.width:=30.0``.

    Args:
        node: the world's node.
        kinds: dataclasses whose fields all have defaults; see `hitab_world.parameters`. No two may
            have a field of the same name. For several, a list is returned.

    Raises:
        HitabError: for an invalid or unknown parameter.
    """
    values = [
        {
            figure.name: declare(node, f"{PARAMETER_GROUP}.{figure.name}", figure)
            for figure in fields(kind)
        }
        for kind in kinds
    ]
    known = {name for one in values for name in one}
    # rclpy ignores overrides of undeclared parameters; a misspelt one would go unnoticed.
    for override in getattr(node, "_parameter_overrides", {}):
        group, _, name = override.partition(".")
        if group == PARAMETER_GROUP and name not in known:
            raise HitabError(f'this world has no parameter "{name}" {has(known, name)}')
    made = [kind(**one) for kind, one in zip(kinds, values, strict=True)]
    return made if len(made) > 1 else made[0]


def declare(node: Node, name: str, figure: Field[Any], description: str = "") -> Any:
    """Declare a parameter with a default and its type, and return its value.

    Raises:
        HitabError: if the given value has another type.
    """
    descriptor = ParameterDescriptor(description=description, read_only=True)
    if figure.default == ():  # ROS knows no type of an empty list
        strings = Parameter.Type.STRING_ARRAY
        return tuple(node.declare_parameter(name, strings, descriptor).value or ())
    return node.declare_parameter(name, figure.default, descriptor).value
