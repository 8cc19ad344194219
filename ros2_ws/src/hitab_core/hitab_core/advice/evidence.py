"""The examples of one state, as advice looks at them, and learning from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.learning import TREE
from hitab_core.learning.boundaries import on_circle
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.numeric.arrays import Booleans, Floats


@dataclass(frozen=True, eq=False)
class Evidence:
    """Examples from which the transition function of one state is learned.

    Attributes:
        state: label of the state.
        values: shape (n, m), the examples' feature values, toroidal ones in [0, period); NaN if
            not known.
        next_states: the n labels.
        default: shape (n,), whether an example is a default one.
        scales: scale of each feature.
        names: names of the features.
        units: units of the features, or empty.
        classifier: classifier to learn with, as in `learn_transitions`.
    """

    state: str
    values: Floats
    next_states: tuple[str, ...]
    default: Booleans
    scales: tuple[Scale, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    classifier: str = TREE

    @classmethod
    def of(
        cls,
        state: str,
        examples: Sequence[Example],
        scales: Sequence[Scale],
        names: Sequence[str],
        units: Sequence[str] = (),
        classifier: str = TREE,
    ) -> Evidence:
        """Return the evidence for one state.

        Args:
            state: label of the state.
            examples: examples of all states; other states' and superseded ones are left out.
            scales, names: scales and names of the features.
            units: units of the features; empty if there are none.
            classifier: classifier to learn with.
        """
        own = [example for example in examples if example.state == state and example.is_learned]
        values = np.array([example.features for example in own], np.float64)
        values = on_circles(values.reshape(len(own), len(scales)), scales)
        return cls(
            state,
            values,
            tuple(example.next_state for example in own),
            np.array([example.is_default for example in own], np.bool_),
            tuple(scales),
            tuple(names),
            tuple(units) or ("",) * len(scales),
            classifier,
        )

    def placed(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the values of a situation, toroidal ones in [0, period)."""
        return tuple(on_circles(np.array([values], np.float64), self.scales)[0].tolist())

    def learn(self) -> TransitionTree | None:
        """Return the tree that is learned from it; None without examples or if it is no tree.

        Raises:
            VocabularyError, FeatureValueError, ValueError: see `TransitionTree.fit`.
        """
        return self._learned

    @cached_property
    def _learned(self) -> TransitionTree | None:
        spec = ClassifierSpec.parse(self.classifier)
        if spec.name != TREE or not self.next_states:
            return None
        tree = TransitionTree(self.scales, feature_names=list(self.names), **spec.arguments)
        return tree.fit(self.values, list(self.next_states), self.default)


def answer_kind(state: str, next_state: str, *, bisects: bool = False) -> ExampleKind:
    """Return the kind of the example that records an answer about a situation.

    A change of state is a correction. Staying is a default example: continue, up to where
    another behavior was demonstrated. As an ordinary example it would move the boundary to
    the demonstrated ones half-way towards a situation that was chosen for another reason; where it
    was chosen to find a boundary (``bisects``), that is right.
    """
    stays = next_state == state and not bisects
    return ExampleKind.DEFAULT if stays else ExampleKind.CORRECTION


def on_circles(values: Floats, scales: Sequence[Scale]) -> Floats:
    """Return a copy of values, shape (n, m), with toroidal ones in [0, period)."""
    placed = np.array(values, np.float64)
    for f, scale in enumerate(scales):
        if scale.kind is FeatureKind.TOROIDAL:
            placed[:, f] = [on_circle(v, scale.period) for v in placed[:, f].tolist()]
    return placed
