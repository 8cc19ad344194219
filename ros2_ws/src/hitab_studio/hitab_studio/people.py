"""The names of the people at the pages."""

from __future__ import annotations

from collections.abc import Collection
from itertools import count

from hitab_client import SwarmError

LONGEST_NAME = 60
"""Characters."""


def checked(text: str) -> str:
    """Return a name as entered by a person.

    Raises:
        SwarmError: if it is none.
    """
    name = text.strip()
    if not name:
        raise SwarmError("Enter your name: others see it, and your commands carry it.")
    if len(name) > LONGEST_NAME:
        raise SwarmError(f"This name has {len(name)} characters: enter at most {LONGEST_NAME}.")
    if not name.isprintable():
        raise SwarmError("This name has control characters: enter it without them.")
    return name


def told_apart(name: str, others: Collection[str]) -> str:
    """Return a name, with a number if others are shown under the same."""
    numbered = (f"{name} ({number})" for number in count(2))
    return name if name not in others else next(n for n in numbered if n not in others)
