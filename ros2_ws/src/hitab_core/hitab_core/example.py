"""Examples ⟨S_t, f_t, S_t+1⟩, recorded from commands; transition functions are learned from them.

Source: the paper, section 3, "Training with HiTAB".
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

CYCLE_MAX = 10**15
"""Largest cycle number of a world; JSON and YAML readers still keep it exact."""

Place = tuple[str, tuple[float | None, ...]]
"""A state and feature values, comparable and hashable; see `Example.place`."""


class ExampleKind(StrEnum):
    """Origin of an example."""

    DEMONSTRATED = "demonstrated"
    CORRECTION = "correction"  # demonstrated after taking over from the learned behavior
    DEFAULT = "default"  # recorded with a command: stay in the commanded state
    SUPERSEDED = "superseded"  # a default example that a command contradicts; not learned from

    @property
    def shown(self) -> str:
        """Text for people."""
        return "overruled" if self is ExampleKind.SUPERSEDED else self.value


@dataclass(frozen=True, slots=True)
class Example:
    """In ``state``, with these ``features``, go to ``next_state``.

    Attributes:
        state, next_state: labels of states; ``state`` may be ``"Start"``.
        features: values in the order and units of the automaton's features.
        kind: origin; the decision tree treats default examples differently (paper, section 3,
            footnote 1).
        number: number of this example in its training, counting from 1; edits refer to it.
        command: number of the command that recorded this example. A command records one or two
            examples, which undo removes together.
        cycle: the world's cycle at which ``features`` held; 0 if unknown.
        ago: time from that cycle to the command, s of simulated time.
        readings: values of all readable features at that cycle, chosen for training or not, in the
            order of ``readable`` of the training or automaton; NaN if missing. Empty if not kept.
        numbers: numbers given with ``next_state``, such as a speed; empty if it takes none.
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
        """Whether transition functions are learned from this example."""
        return self.kind is not ExampleKind.SUPERSEDED

    @property
    def point(self) -> tuple[float | None, ...]:
        """The feature values, made comparable: None instead of NaN, and 0.0 instead of -0.0."""
        return tuple(None if math.isnan(value) else value + 0.0 for value in self.features)

    @property
    def place(self) -> Place:
        """The state and `point`; examples that share them should agree on the next state."""
        return self.state, self.point

    @property
    def leaves(self) -> bool:
        """Whether a command leaves the state; default examples of the same place contradict it."""
        return self.next_state != self.state and not self.is_default

    def with_columns(self, columns: Iterable[int]) -> Example:
        """Return a copy with only the feature values at these indices."""
        return replace(self, features=tuple(self.features[i] for i in columns))


def contradictions(examples: Iterable[Example]) -> list[list[Example]]:
    """Return groups of ordinary examples of one place with different next states.

    No function can agree with a whole group; a tree draws one next state at random in each tick.
    """
    groups: dict[Place, list[Example]] = {}
    for example in examples:
        if not example.is_default:
            groups.setdefault(example.place, []).append(example)
    return [group for group in groups.values() if len({e.next_state for e in group}) > 1]
