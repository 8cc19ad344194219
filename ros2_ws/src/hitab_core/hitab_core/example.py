"""What a demonstrator's command teaches: one example of a transition function."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum


class ExampleKind(StrEnum):
    """Where an example comes from."""

    DEMONSTRATED = "demonstrated"
    CORRECTION = "correction"  # demonstrated after taking over from the learned behavior
    DEFAULT = "default"  # recorded beside a demonstrated one: keep doing what was commanded


@dataclass(frozen=True, slots=True)
class Example:
    """In ``state``, seeing ``features``, go to ``next_state``.

    Attributes:
        state, next_state: labels of states, or ``"Start"``.
        features: values in the order and units of the automaton's features.
        kind: a tree treats default examples differently (paper, section 3, footnote 1).
        number: unique within a training, counting from 1; edits refer to it.
        command: number of the command that recorded it; undoing that removes all of them.
        cycle: the world's cycle when it was recorded, 0 where unknown.
    """

    state: str
    features: tuple[float, ...]
    next_state: str
    kind: ExampleKind = ExampleKind.DEMONSTRATED
    number: int = 0
    command: int = 0
    cycle: int = 0

    @property
    def is_default(self) -> bool:
        """Whether this is a default example."""
        return self.kind is ExampleKind.DEFAULT

    def with_columns(self, columns: Iterable[int]) -> Example:
        """Return it with only the values at these indices."""
        return replace(self, features=tuple(self.features[i] for i in columns))
