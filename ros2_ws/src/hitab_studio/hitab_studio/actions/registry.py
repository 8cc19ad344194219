"""The actions by name."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hitab_client import SwarmError
from hitab_studio.page import Page

Data = Mapping[str, Any]
Action = Callable[[Page, Data], Awaitable[None]]

REGISTERED_ACTIONS: dict[str, Action] = {}
REPEATED: set[str] = set()
"""Actions that fast clicking repeats."""

URGENT: set[str] = set()
"""Actions that wait for no other one."""


def action(
    name: str, *, repeats: bool = False, urgent: bool = False
) -> Callable[[Action], Action]:
    """Register a function as the action with this name.

    Args:
        name: used by pages.
        repeats: whether a double click performs it twice; otherwise once.
        urgent: whether it is performed at once, whatever the page has asked for before.
    """

    def register(function: Action) -> Action:
        REGISTERED_ACTIONS[name] = function
        if repeats:
            REPEATED.add(name)
        if urgent:
            URGENT.add(name)
        return function

    return register


def number_from(values: Data, name: str) -> float:
    """Return a number that a person typed.

    Raises:
        SwarmError: if it is none.
    """
    try:
        return float(values[name])
    except ValueError:
        raise SwarmError(f"Give {name} as a number.") from None
