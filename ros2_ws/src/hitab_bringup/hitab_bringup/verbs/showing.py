"""What was learned, in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hitab_client import Learned


def as_text(learned: Learned) -> str:
    """Return the states, transitions and trees of what was learned."""
    from hitab_core import automaton_as_text

    if learned.automaton is None:
        return f"{learned.name}: nothing can be shown; it has no example, or another classifier"
    return automaton_as_text(learned.automaton)
