"""Example of a transition function, as a demonstrator's command gives it."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

CYCLE_MAX = 10**15
"""Last cycle that a world may count to; JSON and YAML readers keep such a number whole."""

Place = tuple[str, tuple[float | None, ...]]
"""A state and values in it; see `Example.place`."""


class ExampleKind(StrEnum):
    """Origin of an example."""

    DEMONSTRATED = "demonstrated"
    CORRECTION = "correction"  # demonstrated after taking over from the learned behavior
    DEFAULT = "default"  # recorded beside a demonstrated one: keep doing what was commanded
    SUPERSEDED = "superseded"  # a default example that a command contradicts; not learned from

    @property
    def shown(self) -> str:
        """Text for people."""
        return "overruled" if self is ExampleKind.SUPERSEDED else self.value


@dataclass(frozen=True, slots=True)
class Example:
    """In ``state``, seeing ``features``, go to ``next_state``.

    Attributes:
        state, next_state: labels of states, or ``"Start"``.
        features: values in the order and units of the automaton's features.
        kind: a tree treats default examples differently (paper, section 3, footnote 1).
        number: unique within a training, counting from 1; edits refer to it.
        command: number of the command that recorded it; undoing that removes all of them.
        cycle: the world's cycle of the situation, 0 where unknown.
        ago: seconds of simulated time from the situation to the command.
        readings: everything that could be read in that situation, in the order of the training's
            or automaton's ``readable``; NaN where there was no value. Empty if not kept.
        numbers: with which ``next_state`` was commanded; empty if it takes none.
    """

    state: str
    features: tuple[float, ...]
    next_state: str
    kind: ExampleKind = ExampleKind.DEMONSTRATED
    number: int = 0
    command: int = 0
    cycle: int = 0
    ago: float = 0.0
    readings: tuple[float, ...] = ()
    numbers: tuple[float, ...] = ()

    @property
    def is_default(self) -> bool:
        """Whether this is a default example, superseded or not."""
        return self.kind in (ExampleKind.DEFAULT, ExampleKind.SUPERSEDED)

    @property
    def is_learned(self) -> bool:
        """Whether a transition function is learned from it."""
        return self.kind is not ExampleKind.SUPERSEDED

    @property
    def point(self) -> tuple[float | None, ...]:
        """Its feature values, comparable: a missing one is None, and -0.0 is 0.0."""
        return tuple(None if math.isnan(value) else value + 0.0 for value in self.features)

    @property
    def place(self) -> Place:
        """Its state and `point`; default and ordinary examples may contradict each other there."""
        return self.state, self.point

    @property
    def leaves(self) -> bool:
        """Whether a command said to leave its state, which default examples contradict."""
        return self.next_state != self.state and not self.is_default

    def with_columns(self, columns: Iterable[int]) -> Example:
        """Return it with only the values at these indices."""
        return replace(self, features=tuple(self.features[i] for i in columns))


def contradictions(examples: Iterable[Example]) -> list[list[Example]]:
    """Return groups of ordinary examples that differ in nothing but the next state.

    No function can obey them all; a tree draws one of them at random in each tick.
    """
    groups: dict[Place, list[Example]] = {}
    for example in examples:
        if not example.is_default:
            groups.setdefault(example.place, []).append(example)
    return [group for group in groups.values() if len({e.next_state for e in group}) > 1]
