"""Ambiguity: questions about examples that several explanations fit, and what the answers do.

"In GotoBall with DistanceTo(closest_taker) = 12.2 m, BallIsKickable: GotoBall, because
DistanceTo(closest_taker) > 8.2 m, or Stop, because BallIsKickable?" If the learned tree and an
alternative (`hitab_core.advice.alternatives`) clearly decide otherwise in a plausible situation
(`hitab_core.advice.situations`), the examples do not say what was meant, and one command in this
situation does.

**An answer is an example** in the situation asked about. A recorded preference
for a feature would be weaker and longer-lived than what the person knows: the person says what to
do there, not why; a preference would need its own place in files, histories and undo, and would
still hold when later examples speak against it. With the example the rejected explanation no
longer fits, or needs one more leaf. Each question is tried before it is asked: for both answers
the tree is learned again with the example. A situation in which both answers make the tree decide
as was answered, wherever the two explanations differ, with no alternative left that decides
otherwise there, is *decisive* and preferred.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.advice.alternatives import finished, growing_alternatives
from hitab_core.advice.evidence import Evidence, answer_kind
from hitab_core.advice.nearness import Nearness
from hitab_core.advice.situations import Origin, Perceived, composed
from hitab_core.advice.support import Decision, Support, SupportedTree, parting, situation_in_words
from hitab_core.example import Example

TRIED = 5
"""How many situations are tried for a question; each costs learning some trees."""

CONTESTED = 50
"""About how many situations an answer is tried on."""


@dataclass(frozen=True, slots=True)
class Alternative:
    """One of two explanations.

    Attributes:
        next_state: what it decides in the situation asked about.
        because: the conditions that make it so, where the two explanations part.
        feature: index of the feature that it tests where the other one tests another.
        support: the examples in the leaf that decides.
    """

    next_state: str
    because: str
    feature: int
    support: Support

    def __str__(self) -> str:
        """Return ``Stop, because BallIsKickable``."""
        return f"{self.next_state}, because {self.because}"


@dataclass(frozen=True)
class Ambiguity:
    """A question that one command answers.

    Attributes:
        state: the state whose decision it is about.
        learned: what the learned tree does at present.
        other: what an alternative would do.
        situation: a value for each feature; NaN: any.
        origin: where the situation comes from.
        share: how often the two differ, as a share of the readings in the state.
        decisive: the least share, over both answers, of the differences that the answer settles;
            1: the answer settles all.
        features: names of the features.
        text: the question.
    """

    state: str
    learned: Alternative
    other: Alternative
    situation: tuple[float, ...]
    origin: Origin
    share: float
    decisive: float
    features: tuple[str, ...]
    text: str
    _trees: tuple[SupportedTree, SupportedTree] = field(repr=False, compare=False)

    @property
    def key(self) -> tuple[str, str, str, str, str]:
        """What makes it the same question again, though examples have been added meanwhile."""
        sides = sorted(
            (self.features[side.feature], side.next_state) for side in (self.learned, self.other)
        )
        return (self.state, *sides[0], *sides[1])

    def differs(self, values: Sequence[float]) -> bool:
        """Return whether the two explanations clearly decide otherwise.

        With it a program can wait for a situation to ask in, or look for one to place.

        Args:
            values: of all features; NaN: not known. If a tested one is not known the answer is
                no.
        """
        a, b = (tree.decide(values) for tree in self._trees)
        return differ(a, b)

    def example(self, next_state: str) -> Example:
        """Return the example that an answer adds, in the situation asked about."""
        kind = answer_kind(self.state, next_state)
        return Example(self.state, self.situation, next_state, kind)

    def ranked(self, situations: Iterable[Sequence[float]]) -> list[tuple[float, ...]]:
        """Return the situations in which the explanations differ, the most telling ones first.

        Args:
            situations: values of all features, such as what could be placed.
        """
        different = [tuple(map(float, s)) for s in situations if self.differs(s)]
        return [s for _, s in finished(_by_decisiveness(self._trees, different))]


def differ(some: Decision | None, other: Decision | None) -> bool:
    """Return whether two decisions are known, sure and clear, and not the same."""
    return (
        some is not None
        and other is not None
        and some.next_state != other.next_state
        and some.sure
        and other.sure
        and some.clear
        and other.clear
    )


def ambiguities(
    evidence: Evidence,
    *,
    readings: ArrayLike = (),
    here: ArrayLike | None = None,
    compose: bool = False,
) -> list[Ambiguity]:
    """Return the questions about the examples of one state, the most useful first.

    There are none about other classifiers than trees. None of them is about a situation in which
    an earlier one is asked; ask the first, and call this again with the answer among the examples.
    For fifteen examples with nine features this takes up to half a second: it is not for a tick.

    Questions are ordered by where their situation comes from (`Origin`), then by how much their
    answers settle, then by how often the explanations differ.

    Args:
        evidence: the examples of the state.
        readings: shape (k, m), what was perceived in this training, in any state, the values of
            other states' examples included. The examples of this state are added.
        here: shape (k,), whether each reading was perceived while this state was active; None: not
            known of any.
        compose: whether to ask about situations that were not perceived but composed. Many of them
            cannot come about, so use it where what is asked about is placed and so checked.

    Raises:
        FeatureValueError, VocabularyError, ValueError: as learning from the examples.
    """
    searching = searched_ambiguities(evidence, readings=readings, here=here, compose=compose)
    return [question for question in searching if question is not None]


def searched_ambiguities(
    evidence: Evidence,
    *,
    readings: ArrayLike = (),
    here: ArrayLike | None = None,
    compose: bool = False,
) -> Iterator[Ambiguity | None]:
    """Yield what `ambiguities` returns, and None wherever something else can be done meanwhile."""
    learned, others = yield from growing_alternatives(evidence)
    if learned is None or not others:
        return
    perceived = Perceived.of(evidence, readings, here)
    usual = SupportedTree(learned, evidence)
    found = []
    for tree in others:
        question = yield from _question(usual, SupportedTree(tree, evidence), perceived, compose)
        if question is not None:
            found.append(question)
    found.sort(key=lambda q: (q.origin, -q.decisive, -q.share))
    kept: list[Ambiguity] = []
    for question in found:
        if not any(question.differs(earlier.situation) for earlier in kept):
            kept.append(question)
            yield question


def _question(
    usual: SupportedTree, other: SupportedTree, perceived: Perceived, compose: bool
) -> Generator[None, None, Ambiguity | None]:
    """Return the question that two explanations give rise to, if they differ anywhere."""
    evidence, pair = usual.evidence, (usual, other)
    features = sorted({*usual.tree.features_used, *other.tree.features_used})

    def differs(values: Sequence[float]) -> bool:
        return differ(usual.decide(values), other.decide(values))

    yield
    different = np.array([differs(row) for row in perceived.values.tolist()], np.bool_)
    origin = Origin.HERE
    rows = perceived.values[different & perceived.here]
    if not len(rows):
        origin = Origin.ELSEWHERE
        rows = perceived.values[different]
    situations = [tuple(row) for row in rows.tolist()]
    if not situations and compose and not perceived.enough:
        origin = Origin.COMPOSED
        situations = [s for s in composed(evidence, perceived, features) if differs(s)]
    if not situations:
        return None
    yield
    ((decisive, situation), *_) = yield from _by_decisiveness(pair, situations)
    sides = [decision for tree in pair if (decision := tree.decide(situation)) is not None]
    at = parting(*(side.path for side in sides))
    learned, alternative = (
        Alternative(
            side.next_state,
            tree.words(side.path[at:]),
            side.path[at][0].feature,
            side.support,
        )
        for side, tree in zip(sides, pair, strict=True)
    )
    here = perceived.times * perceived.here
    where = situation_in_words(evidence, situation, features)
    return Ambiguity(
        evidence.state,
        learned,
        alternative,
        situation,
        origin,
        share=float(here[different].sum() / here.sum()),
        decisive=decisive,
        features=evidence.names,
        text=f"In {evidence.state} with {where}: {_what(learned, evidence)}, "
        f"or {_what(alternative, evidence)}?",
        _trees=pair,
    )


def _what(side: Alternative, evidence: Evidence) -> str:
    doing = "stay" if side.next_state == evidence.state else f"go to {side.next_state}"
    return f"{doing}, because {side.because}"


def _by_decisiveness(
    pair: tuple[SupportedTree, SupportedTree], situations: Sequence[tuple[float, ...]]
) -> Generator[None, None, list[tuple[float, tuple[float, ...]]]]:
    """Return situations in which two explanations differ, most decisive first.

    With each comes the share of these situations that either answer settles. They are tried in the
    order of their distance from an example, `TRIED` of them evenly over all, up to the first that
    settles everything; the others count as settling nothing. Near an example is best: there the
    person has just said what to do, and the situation differs from it only in what the question
    is about. But too near one, the wrong explanation may only move its threshold.
    """
    evidence = pair[0].evidence
    used = sorted({f for tree in pair for f in tree.tree.features_used})
    nearness = Nearness(evidence.values, evidence.scales, used)
    nearest = sorted(dict.fromkeys(situations), key=nearness)
    contested = nearest[:: len(nearest) // CONTESTED + 1]
    rated = [(0.0, situation) for situation in nearest]
    for i in sorted({round(k * (len(nearest) - 1) / (TRIED - 1)) for k in range(TRIED)}):
        shares = []
        for right in pair:
            shares.append((yield from _settled(right, nearest[i], contested)))
        settled = min(shares)
        rated[i] = (settled, nearest[i])
        if settled == 1.0:
            break
    return sorted(rated, key=lambda item: -item[0])


def _settled(
    right: SupportedTree, situation: tuple[float, ...], contested: Sequence[tuple[float, ...]]
) -> Generator[None, None, float]:
    """Return in which share of situations all is right, once the answer was that.

    It is if the tree decides there as it should, and no alternative clearly decides otherwise.

    Args:
        right: the explanation that is meant.
        situation: that is asked about.
        contested: what should be settled.
    """
    decision = right.decide(situation)
    assert decision is not None
    evidence = right.evidence.with_answer(situation, decision.next_state)
    tree, others = yield from growing_alternatives(evidence)
    assert tree is not None
    after, rivals = SupportedTree(tree, evidence), []
    for other in others:
        yield
        rivals.append(SupportedTree(other, evidence))
    yield
    settled = 0
    for values in contested:
        then, wanted = after.decide(values), right.decide(values)
        settled += (
            then is not None
            and wanted is not None
            and then.sure
            and then.next_state == wanted.next_state
            and not any(differ(then, rival.decide(values)) for rival in rivals)
        )
    return settled / len(contested)
