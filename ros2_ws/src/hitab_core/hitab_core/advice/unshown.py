"""Situations without examples: the one in which an answer would teach the agent most.

An example is evidence for its situation, and weaker evidence for situations farther away. The
examples of a state give each next state a weight in a situation: the inverse of the
distance to the nearest example of it. A next state that was never shown has weight 1, as if its
example were as far away as examples usually are from each other (`hitab_core.advice.nearness`).

The *gain* of an answer is a sum over all situations that the agent met in the state:
the share of the weights of all but the heaviest next state, times the part of the
way by which the situation asked about is nearer than the nearest example. Each kind of situation,
by its boolean and categorical values, counts 1 in all, however often it was met.

Before all that, an agent asks about assumed sides of circles: where a tree without
assumptions about circles decides otherwise (`hitab_core.learning.boundaries`). The agent asks in
the middle, so that an answer halves the open part, as long as that part is large.

Default examples from the entry of a state say *stay* where no person has decided that; they are
taken for `ASSUMED` away even where they are.

Source:
    D. D. Lewis and W. A. Gale, A sequential algorithm for training text classifiers, SIGIR 1994:
    to ask where the answer is least sure.
    B. Settles, Active learning literature survey, 2009, section 3.6: weighted by how many other
    situations are like it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import apart
from hitab_core.automaton import START
from hitab_core.domain import FeatureKind
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.numeric.arrays import Booleans, Floats
from hitab_core.numeric.spread import spreads

ASSUMED = 0.2
"""The least distance of a default example of an entry, in usual distances."""

TOUCHING = 0.01
"""No distance counts as less: an example does not decide all."""

NO_EXAMPLE_DISTANCE = 1e6
"""The distance of the nearest example where there is none."""

GAIN_MIN = 0.1
"""Minimum gain of an answer, as a part of all that can be learned of one kind of situation."""

FARTHER = 2.0
"""A decision is supported if no example of another one is nearer than so many times its own."""


@dataclass(frozen=True)
class Unshown:
    """A situation without an example of the right decision.

    Attributes:
        state: label of the state that was active.
        situation: a value for each feature; NaN if missing.
        decided: decision of the learned tree there; empty if there is no tree.
        next_states: possible answers, the most probable first.
        gain: gain of an answer.
        bisects: whether the situation is in the middle of a side of a circle of which only the
            beginning was shown.
        supported: whether the examples speak for the decision: others are at least `FARTHER` times
            as far away.
    """

    state: str
    situation: tuple[float, ...]
    decided: str
    next_states: tuple[str, ...]
    gain: float
    bisects: bool = False
    supported: bool = False


def unshown(
    evidence: Evidence, met: Sequence[Sequence[float]], labels: Sequence[str], assumed: Booleans
) -> Unshown | None:
    """Return the situation whose answer has the largest gain; None below `GAIN_MIN`.

    Args:
        evidence: the examples of the state.
        met: feature values of the situations met in the state.
        labels: labels of possible answers, besides those that were shown.
        assumed: shape (n,), which of the examples come from the entry of the state.

    Raises:
        FeatureValueError, VocabularyError, ValueError: see `Evidence.learn`.
    """
    shown = evidence.next_states
    likely = [
        label for label in dict.fromkeys([*shown, evidence.state, *labels]) if label != START
    ]
    if not met or not likely:  # nothing could be answered
        return None
    situations = np.unique([evidence.placed(values) for values in met], axis=0, equal_nan=True)
    parts = _each_kind_once(situations, evidence)
    spread = _spread(evidence, situations)
    away = apart(situations, evidence.values, evidence.scales, spread)
    away = np.maximum(away, np.where(assumed, ASSUMED, TOUCHING))
    of_label = [[next_state == label for next_state in shown] for label in likely]
    weights = np.array(
        [
            (1.0 / away[:, those]).max(axis=1, initial=0.0 if any(those) else 1.0)
            for those in of_label
        ]
    )
    open_part = 1.0 - weights.max(axis=0) / weights.sum(axis=0)
    nearest = away.min(axis=1, initial=NO_EXAMPLE_DISTANCE)
    near = np.maximum(apart(situations, situations, evidence.scales, spread), TOUCHING)
    gains = (nearest[:, None] / (nearest[:, None] + near)).T @ (open_part * parts)
    place, most = int(gains.argmax()), float(gains.max())
    taken = _taken_for_granted(evidence, situations)
    half = float(parts[taken].sum()) / 2  # the part that the answer decides
    bisects = half >= GAIN_MIN
    if bisects:
        there = np.flatnonzero(taken)[np.argsort(nearest[taken], kind="stable")]
        place, most = int(there[len(there) // 2]), half
    if most < GAIN_MIN:
        return None
    # As it was met: an answer overrules a default example that has the same values.
    as_met = {str(evidence.placed(values)): tuple(values) for values in met}
    situation = as_met[str(tuple(situations[place].tolist()))]
    tree = evidence.learn()
    # Without examples a state stays as it is.
    decided = "" if shown else evidence.state
    if tree is not None:
        decided = str(tree.predict([situation])[0])
    order = [likely[i] for i in np.argsort(-weights[:, place], kind="stable").tolist()]
    next_states = tuple(dict.fromkeys(label for label in (decided, *order) if label))
    speaking = {label: float(weights[i, place]) for i, label in enumerate(likely)}
    others = max((w for label, w in speaking.items() if label != decided), default=0.0)
    supported = speaking.get(decided, 0.0) >= FARTHER * others and not bisects
    return Unshown(evidence.state, situation, decided, next_states, most, bisects, supported)


def _taken_for_granted(evidence: Evidence, situations: Floats) -> Booleans:
    """Return where a decision of a tree rests only on an assumed side of a circle."""
    nowhere = np.zeros(len(situations), np.bool_)
    if all(scale.kind is not FeatureKind.TOROIDAL for scale in evidence.scales):
        return nowhere
    spec = ClassifierSpec.parse(evidence.classifier)
    shown = replace(spec, arguments={**spec.arguments, "all_around": True})
    tree = evidence.learn()
    tight = None if tree is None else replace(evidence, classifier=str(shown)).learn()
    if tree is None or tight is None:
        return nowhere
    return np.asarray(tree.predict(situations) != tight.predict(situations))


def _spread(evidence: Evidence, situations: Floats) -> Floats:
    """Return the usual differences of examples; of all that was met where these are all equal."""
    own = spreads(evidence.values, evidence.scales)
    differ = [len(np.unique(column[~np.isnan(column)])) > 1 for column in evidence.values.T]
    return np.where(
        differ, own, spreads(np.vstack([evidence.values, situations]), evidence.scales)
    )


def _each_kind_once(situations: Floats, evidence: Evidence) -> Floats:
    """Return weights of situations, which add up to 1 for each kind."""
    discrete = [f for f, scale in enumerate(evidence.scales) if not scale.kind.is_measured]
    kinds = np.unique(situations[:, discrete], axis=0, return_inverse=True, equal_nan=True)[1]
    return np.asarray(1.0 / np.bincount(kinds.ravel())[kinds.ravel()])
