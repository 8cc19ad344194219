"""Rivals: another feature would explain the examples of a state as well.

Examples often differ in several features at once: where a robot is far from the dirt, its
battery is low, too. The learned tree rests on one of these features, and a person may have meant
the other. The tree that is learned without the one is a rival if it explains the examples as well,
with as few leaves. Where the two decide otherwise in situations that were met, an answer tells
which is meant. It is an ordinary example, so it needs no option of the learner.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import apart
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import Leaf, nodes
from hitab_core.numeric.spread import spreads

DISAGREEMENT_MIN = 0.05
"""Minimum part of the situations met in a state that a rival decides otherwise."""


@dataclass(frozen=True)
class Rival:
    """A situation in which a tree and its rival decide otherwise.

    Attributes:
        state: label of the state that was active.
        situation: a value for each feature; NaN if missing.
        decided: decision of the learned tree there.
        otherwise: decision of the rival.
        feature: index of the feature that only the learned tree tests.
        instead: indices of the features that only the rival tests.
        part: the part of the situations met that they decide otherwise.
    """

    state: str
    situation: tuple[float, ...]
    decided: str
    otherwise: str
    feature: int
    instead: tuple[int, ...]
    part: float


def rival(evidence: Evidence, met: Sequence[tuple[float, ...]]) -> Iterator[Rival | None]:
    """Yield the rival of each feature that the learned tree tests; None if it has none.

    Args:
        evidence: the examples of the state.
        met: feature values of the situations met in the state.

    Raises:
        FeatureValueError, VocabularyError, ValueError: see `Evidence.learn`.
    """
    tree = evidence.learn()
    if tree is None or not met:
        return
    for feature in tree.features_used:
        yield _without(feature, tree, evidence, met)


def _without(
    feature: int, tree: TransitionTree, evidence: Evidence, met: Sequence[tuple[float, ...]]
) -> Rival | None:
    placed = np.array([evidence.placed(values) for values in met])
    masked = evidence.values.copy()
    masked[:, feature] = 0.0
    other = replace(evidence, values=masked).learn()
    if other is None or _errors(other, masked, evidence) > _errors(
        tree, evidence.values, evidence
    ):
        return None
    instead = tuple(f for f in other.features_used if f not in tree.features_used)
    if not instead or _leaves(other) > _leaves(tree):
        return None
    elsewhere = placed.copy()
    elsewhere[:, feature] = 0.0
    ours, theirs = tree.predict(placed), other.predict(elsewhere)
    places = np.flatnonzero(ours != theirs)
    if len(places) < DISAGREEMENT_MIN * len(met):
        return None
    # In the middle of where they disagree, so that the answer settles as much as possible.
    there = placed[places]
    away = apart(there, there, evidence.scales, spreads(placed, evidence.scales))
    place = int(places[np.where(np.isfinite(away), away, 0.0).sum(axis=1).argmin()])
    decisions = str(ours[place]), str(theirs[place])
    part = len(places) / len(met)
    return Rival(evidence.state, met[place], *decisions, feature, instead, part)


def _errors(tree: TransitionTree, values: np.ndarray, evidence: Evidence) -> int:
    """Return how many examples a tree decides otherwise than shown."""
    return int((tree.predict(values) != np.array(evidence.next_states)).sum())


def _leaves(tree: TransitionTree) -> int:
    return sum(isinstance(node, Leaf) for node in nodes(tree.root_))
