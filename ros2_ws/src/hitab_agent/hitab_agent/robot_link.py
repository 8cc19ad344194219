"""Connects an agent to its own robot: sensors in, motors out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, Protocol

from hitab_msgs import msg
from rclpy.node import Node

from hitab_core import Domain, HitabError

OnPercept = Callable[[msg.Percept], tuple[Sequence[float], str]]


class RobotLink(Protocol):
    """The connection to a robot; a domain names its class in `Domain.link`."""

    def __init__(self, node: Node, world: str, on_percept: OnPercept) -> None:
        """Subscribe to the robot's topics.

        Args:
            node: of the agent, in the agent's namespace.
            world: name of the world, if there is one.
            on_percept: call it with a percept made from the robot's sensors, at the rate at
                which the agent should tick. It returns the action: values in the domain's
                layout, none if something was wrong, and a text to say.
        """

    def close(self) -> None:
        """Stop the robot: the agent is shutting down."""


def link_class(domain: Domain) -> Any:
    """Return the class that connects an agent of this domain to its robot.

    Raises:
        HitabError: if it cannot be imported.
    """
    module, _, name = domain.link.partition(":")
    try:
        return getattr(import_module(module), name)
    except (ImportError, AttributeError) as error:
        raise HitabError(
            f'domain "{domain.name}": its link "{domain.link}" cannot be imported: {error}; '
            'it must read "module:Class"'
        ) from error
