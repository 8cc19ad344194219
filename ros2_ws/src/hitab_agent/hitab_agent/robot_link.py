"""Connects an agent to its own robot: sensors in, motors out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

from hitab_msgs import msg

from hitab_core import Domain, HitabError

OnPercept = Callable[[msg.Percept], tuple[Sequence[float], str]]
"""Called by a link with a percept made from the sensors, whenever the agent should tick; returns
the action, in the domain's layout and empty if something was wrong, and a text to say."""


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
