"""What is learned from which features, and how it is shown."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from hitab_client import Learned


Features = Annotated[
    list[str],
    typer.Option("--feature", "-f", help='A feature, such as "DistanceTo(ball)". Repeatable.'),
]
ShowOnly = Annotated[
    bool, typer.Option("--show", help="Only show what would be learned; change nothing.")
]


def as_text(learned: Learned) -> str:
    """Return the states, transitions and trees of what was learned."""
    from hitab_core import automaton_as_text

    if learned.automaton is None:
        return f"{learned.name}: nothing can be shown; it has no example, or another classifier"
    return automaton_as_text(learned.automaton)
