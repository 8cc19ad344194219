"""The names of the people at the pages."""

from __future__ import annotations

from collections.abc import Collection
from itertools import count

from hitab_client import SwarmError

NAME_LENGTH_MAX = 60
"""Maximum length of a name, characters."""


def checked(text: str) -> str:
    """Return the name in a person's input.

    Raises:
        SwarmError: if the input is not a valid name.
    """
    name = text.strip()
    if not name:
        raise SwarmError("Enter your name: others see it, and your commands carry it.")
    if len(name) > NAME_LENGTH_MAX:
        raise SwarmError(f"This name has {len(name)} characters: enter at most {NAME_LENGTH_MAX}.")
    if not name.isprintable():
        raise SwarmError("This name has control characters: enter it without them.")
    return name


def distinct(name: str, others: Collection[str]) -> str:
    """Return a name, with a number if other people have the same one."""
    numbered = (f"{name} ({number})" for number in count(2))
    return name if name not in others else next(n for n in numbered if n not in others)
