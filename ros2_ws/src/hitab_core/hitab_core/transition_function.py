"""The interface between automata and the functions that decide their transitions.

A transition function belongs to one state: it maps a feature vector to a distribution over next
states. `TransitionTree` learns one; `HandWritten` is one that a programmer wrote.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

Values = list[float | None]
"""Feature values by slot; None if not read in this tick."""

Decide = Callable[[Values, Callable[[int], float], Callable[[], float]], int]
"""``decide(values, read, draw)`` returns the index of the next state.

``values[slot]`` is None until ``read(slot)`` is called, which raises `FeatureValueError` if there
is no value: a `NoValueError` if the decision may do without. ``draw()`` is uniform on [0, 1).
"""


@dataclass(frozen=True, slots=True)
class Explanation:
    """Reason for a decision: the tests that held and the distribution drawn from.

    Attributes:
        tests: readable conditions in the order of testing, such as ``"DistanceTo(ball) <= 4"``.
        features: indices of the automaton's features that were used.
        distribution: probability of each next state, by label; empty if only the choice is known.
    """

    tests: tuple[str, ...]
    features: tuple[int, ...]
    distribution: Mapping[str, float]


class TransitionFunction(Protocol):
    """Decides the next state in one state."""

    @property
    def features_used(self) -> tuple[int, ...]:
        """Indices of the automaton's features that can affect the decision."""

    def compile(
        self, slots: Sequence[int], states: Mapping[str, int], *, most_probable: bool = False
    ) -> Decide:
        """Return the decision as a fast function.

        Args:
            slots: the slot of each feature of the automaton.
            states: the index of each state, by label.
            most_probable: always take the most probable state instead of drawing one.
        """

    def explain(self, values: Sequence[float], names: Sequence[str]) -> Explanation:
        """Explain the decision for a full feature vector; ``names`` name its features."""

    def retrace(self, values: Sequence[float | None], names: Sequence[str]) -> Explanation:
        """Explain a past decision from its feature values, without repeating it.

        Args:
            values: values of the features; None if the decision did not read one, NaN if it was
                missing. The explanation ends where such a value would be needed.
            names: names of the features.
        """


class NumberFunction(Protocol):
    """Gives the numbers with which a state's behavior is performed."""

    def __call__(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the numbers, given the automaton's features, NaN where one has no value.

        Nothing if no moment shown has any of these values.
        """

    def distance(self, values: Sequence[float]) -> float:
        """Return how far a situation is from the nearest moment shown, in usual differences."""


class LearnedTransition(TransitionFunction, Protocol):
    """A transition function that was learned from examples."""

    def digest(self) -> str:
        """Return a SHA-256 in hexadecimal; equal examples give equal digests."""


@dataclass(frozen=True)
class HandWritten:
    """A transition function that a programmer wrote.

    ``choose(*values)`` takes the values of ``features_used``, in that order, and returns the label
    of the next state.
    """

    choose: Callable[..., str]
    features_used: tuple[int, ...] = ()

    def compile(
        self, slots: Sequence[int], states: Mapping[str, int], *, most_probable: bool = False
    ) -> Decide:
        """Return the decision as a function of slots; see `TransitionFunction.compile`."""
        used = tuple(slots[i] for i in self.features_used)
        choose = self.choose

        def decide(values: Values, read: Callable[[int], float], draw: Callable[[], float]) -> int:
            arguments = []
            for slot in used:
                value = values[slot]
                arguments.append(read(slot) if value is None else value)
            return states[choose(*arguments)]

        return decide

    def explain(self, values: Sequence[float], names: Sequence[str]) -> Explanation:
        """Explain the decision for a full feature vector."""
        chosen = self.choose(*(values[i] for i in self.features_used))
        return Explanation(("hand-written",), self.features_used, {chosen: 1.0})

    def retrace(self, values: Sequence[float | None], names: Sequence[str]) -> Explanation:
        """Explain a past decision without calling ``choose`` again."""
        read = tuple(i for i in self.features_used if values[i] is not None)
        return Explanation(("hand-written",), read, {})
