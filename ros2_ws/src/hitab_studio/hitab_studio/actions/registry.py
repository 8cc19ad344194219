"""Registry of the actions, by name."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hitab_client import SwarmError
from hitab_studio.pages.page import Page

Data = Mapping[str, Any]
Action = Callable[[Page, Data], Awaitable[None]]

REGISTERED_ACTIONS: dict[str, Action] = {}
REPEATED: set[str] = set()
"""Names of the actions that a double click repeats."""

URGENT: set[str] = set()
"""Names of the actions that do not wait for pending ones."""


def action(
    name: str, *, repeats: bool = False, urgent: bool = False
) -> Callable[[Action], Action]:
    """Register a function as the action with this name.

    Args:
        name: name of the action in requests of pages.
        repeats: whether a double click performs the action twice.
        urgent: whether the action does not wait for the page's pending requests.
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
    """Return the number that a person entered under a name.

    Raises:
        SwarmError: if the input is not a number.
    """
    try:
        return float(values[name])
    except ValueError:
        raise SwarmError(f"Give {name} as a number.") from None
