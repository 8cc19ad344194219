"""The link of an agent to its own robot: sensors in, motors out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any, Protocol

from hitab_msgs import msg

from hitab_core import Domain, HitabError
from hitab_ros import Stop

OnPercept = Callable[[msg.Percept], tuple[Sequence[float], str]]
"""Called by a link with each percept, when the agent should tick. Returns the action, in the
domain's layout, and a text to say. The action is empty while the robot has to stand still."""


class RobotStop(Protocol):
    """Interface of a robot's stop; a link with a relay sets `AgentNode.stop`.

    Attributes:
        why: why the robot may not act, and the way out; empty if it may.
        is_emergency: whether an emergency stop holds it.
    """

    @property
    def why(self) -> str:
        """Why the robot may not act, and the way out; empty if it may."""

    @property
    def is_emergency(self) -> bool:
        """Whether an emergency stop holds the robot."""

    def cause(self, why: str) -> None:
        """Stop the robot until it is re-armed; ``why`` its agent cannot act, empty if it can."""


class OwnStop:
    """The stop of a robot whose link has no relay: its agent withholds its actions."""

    def __init__(self, node: Any, *, rearms: bool) -> None:
        self._stop = Stop(node, node.stands, changed=node.stop_changed, rearms=rearms)

    @property
    def why(self) -> str:
        """Why the robot may not act, and the way out; empty if it may."""
        return self._stop.why

    @property
    def is_emergency(self) -> bool:
        """Whether an emergency stop holds the robot."""
        return self._stop.switch.engaged

    def cause(self, why: str) -> None:
        """Stop the robot until it is re-armed; ``why`` its agent cannot act, empty if it can."""
        self._stop.machine.cause("agent", why)


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
