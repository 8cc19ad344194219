"""The figures of a kind of world as ROS parameters, declared from their dataclass."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any, TypeVar

from rcl_interfaces.msg import ParameterDescriptor
from rclpy.node import Node

from hitab_core.errors import HitabError, has

GROUP = "parameters"

Figures = TypeVar("Figures")


def declare_figures(node: Node, kind: type[Figures]) -> Figures:
    """Return the figures that a node's parameters give, such as ``-p parameters.width:=30.0``.

    Args:
        node: the world's node.
        kind: a dataclass whose fields all have defaults and whose construction raises a
            ValueError, naming the figure, for what cannot be.

    Raises:
        HitabError: for a figure that cannot be or that there is not.
    """
    values: dict[str, Any] = {}
    for figure in fields(kind):  # type: ignore[arg-type]
        default = figure.default if figure.default is not MISSING else None
        name = f"{GROUP}.{figure.name}"
        values[figure.name] = node.declare_parameter(
            name, default, ParameterDescriptor(read_only=True)
        ).value
    # rclpy tells of overrides only what was declared; a misspelt one would go unnoticed.
    overrides = getattr(node, "_parameter_overrides", {})
    for name in overrides:
        group, _, figure_name = name.partition(".")
        if group == GROUP and figure_name not in values:
            raise HitabError(f'this world has no figure "{figure_name}" {has(values)}')
    try:
        return kind(**values)
    except ValueError as error:
        raise HitabError(str(error)) from error
