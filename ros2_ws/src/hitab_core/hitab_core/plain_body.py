"""The body of an agent whose features and behaviors are functions of a list of numbers."""

from __future__ import annotations

from collections.abc import Sequence

Percept = list[float]
Action = Sequence[float]


class PlainBody:
    """The last percept and the action of this cycle, both lists of numbers.

    Attributes:
        percept: values, in an order that the domain's functions know.
        heard: messages that came with it.
        action: set by a basic behavior, or empty.
    """

    def __init__(self, name: str) -> None:
        self.percept: Percept = []
        self.heard: list[str] = []
        self.action: Action = ()

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take a percept; forget the action of the last cycle."""
        self.percept, self.heard = list(values), list(heard)
        self.action = ()

    def act(self) -> tuple[Action, str]:
        """Return the action; a plain body says nothing."""
        return self.action, ""
