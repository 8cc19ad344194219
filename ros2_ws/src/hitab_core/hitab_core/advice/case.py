"""What mistakes are looked for in: examples by state, corrections, and what they say together."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from hitab_core.advice.neighbors import Neighbors, distances, neighbors
from hitab_core.advice.proposals import Correction
from hitab_core.advice.spread import spreads
from hitab_core.arrays import Floats
from hitab_core.domain import Scale
from hitab_core.errors import TrainingError
from hitab_core.example import Example, superseding
from hitab_core.learning.transition_learning import TREE, Learn, learner
from hitab_core.transition_function import Explanation, LearnedTransition
from hitab_core.wording import quantity


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """The examples of one state and the corrections of its function.

    Attributes:
        state: its label.
        own: the examples, without those that corrections recorded and without default examples
            that an ordinary one overrules.
        corrected: the corrections, by their index.
        around: what examples, and after them corrections, say about one another.
    """

    state: str
    own: tuple[Example, ...]
    corrected: Mapping[int, Correction]
    around: Neighbors

    def said(self, row: int) -> str:
        """Return the next state of an example, or of a correction, which come after."""
        if row < len(self.own):
            return self.own[row].next_state
        return [*self.corrected.values()][row - len(self.own)].right

    def nearest(self, row: int) -> list[int]:
        """Return all other examples and corrections, the nearest first."""
        order = np.argsort(self.around.apart[row], kind="stable").tolist()
        return [other for other in order if other != row]

    def accuser(self, row: int) -> int:
        """Return the nearest example or correction with another next state; -1 if none has."""
        others = (other for other in self.nearest(row) if self.said(other) != self.said(row))
        return next(others, -1)

    def is_correction(self, row: int) -> bool:
        """Return whether that is a correction."""
        return row >= len(self.own)


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """All that proposals are made from.

    Attributes:
        examples: that are judged: without those that corrections recorded, and without default
            examples that an ordinary one overrules.
        scales: how the values of each feature compare.
        names: of the features.
        corrections: all so far.
        learn: learns the function of a state.
        spread: usual differences of the features.
        everything: all examples given.
    """

    examples: tuple[Example, ...]
    scales: tuple[Scale, ...]
    names: tuple[str, ...]
    corrections: tuple[Correction, ...]
    learn: Learn
    spread: Floats
    everything: tuple[Example, ...]
    _places: dict[str, Place] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        examples: Sequence[Example],
        scales: Sequence[Scale],
        corrections: Sequence[Correction],
        learn: Learn | None,
        names: Sequence[str] | None,
    ) -> Case:
        """Prepare a case; see `hitab_core.advice.mistakes.propose`."""
        named = tuple(names) if names else tuple(f"feature {f}" for f in range(len(scales)))
        for what, given in [
            *((f"example {e.number}", e.features) for e in examples),
            *((f"correction {i + 1}", c.features) for i, c in enumerate(corrections)),
        ]:
            if len(given) != len(scales):
                raise TrainingError(
                    f"{what} has {quantity(len(given), 'value')} for "
                    f"{quantity(len(scales), 'feature')}; give one per feature, NaN if missing"
                )
        recorded = {c.number for c in corrections if c.number}
        others = superseding([e for e in examples if e.number not in recorded])
        judged = tuple(example for example in others if example.is_learned)
        values = _matrix([e.features for e in judged] + [c.features for c in corrections], scales)
        return cls(
            judged,
            tuple(scales),
            named,
            tuple(corrections),
            learn or learner(TREE, scales, named),
            spreads(values, scales),
            tuple(examples),
        )

    def place(self, state: str) -> Place:
        """Return what is known of a state."""
        if state not in self._places:
            own = tuple(example for example in self.examples if example.state == state)
            corrected = {i: c for i, c in enumerate(self.corrections) if c.state == state}
            values = _matrix(
                [e.features for e in own] + [c.features for c in corrected.values()], self.scales
            )
            next_states = [e.next_state for e in own] + [c.right for c in corrected.values()]
            trusted = np.arange(len(values)) >= len(own)
            apart = distances(values, values, self.scales, self.spread)
            around = neighbors(apart, next_states, trusted)
            self._places[state] = Place(state, own, corrected, around)
        return self._places[state]

    def taught(self, place: Place, without: Example | None = None) -> LearnedTransition | None:
        """Return the function of a state by its examples and corrections, perhaps without one."""
        shown = [example for example in place.own if example is not without]
        shown += [Example(c.state, c.features, c.right) for c in place.corrected.values()]
        return self.learned(shown)

    def learned(self, own: Sequence[Example]) -> LearnedTransition | None:
        """Return the function that is learned from examples of one state; None from none."""
        if not own:
            return None
        X = _matrix([e.features for e in own], self.scales)
        return self.learn(X, [e.next_state for e in own], [e.is_default for e in own])

    def explain(self, function: LearnedTransition, values: Sequence[float]) -> Explanation:
        """Explain a decision; a missing value ends the explanation."""
        known = [None if math.isnan(value) else value for value in values]
        return function.retrace(known, self.names)

    def decides(self, function: LearnedTransition | None, correction: Correction) -> str:
        """Return what a function decides where it was corrected; the state if there is none."""
        if function is None:
            return correction.state
        odds = self.explain(function, correction.features).distribution
        return max(odds, key=lambda label: (odds[label], label == correction.wrong))

    def recorded_by(self, command: int) -> tuple[int, ...]:
        """Return the numbers of all examples that a command recorded, ascending."""
        return tuple(sorted(e.number for e in self.everything if e.command == command))


def _matrix(rows: Sequence[Sequence[float]], scales: Sequence[Scale]) -> Floats:
    return np.array(rows, np.float64).reshape(len(rows), len(scales))


def as_shown(example: Example, values: tuple[float, ...] | None = None) -> Correction:
    """Return what an example says, perhaps of other values, in the form of a correction."""
    label = example.next_state
    return Correction(example.state, example.features if values is None else values, label, label)
