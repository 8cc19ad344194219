"""Ambiguity: questions about examples of a state that several explanations fit.

"In GotoBall with DistanceTo(closest_taker) = 12.2 m, BallIsKickable: GotoBall, because
DistanceTo(closest_taker) > 8.2 m, or Stop, because BallIsKickable?"

C4.5 splits a node by the feature with the largest gain ratio. With few examples several features
often come out equal or nearly so, and then a tie rule or a little noise decides what the robot
does. An *alternative* is the tree that grows if one node is split by such another feature. It must
be as good an explanation:

- the other feature is one that C4.5 would have considered (at least average gain), and its gain
  ratio is at least `NEARLY` of the best one;
- the tree fits as many examples, and has no more leaves.

If the learned tree and an alternative clearly decide otherwise on readings that the agent had
in this training, the examples do not say what was meant, and one command in this situation does.
**An answer is an example** in the situation asked about: the person says what to do there, not
why. With the example the rejected explanation no longer fits, or needs one more leaf.

References:
    J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapter 2.
    T. M. Mitchell, Generalization as search, Artificial Intelligence 18, 1982: what consistent
    hypotheses disagree on is what to ask about.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import Nearness
from hitab_core.advice.support import Decision, SupportedTree, parting, situation_in_words
from hitab_core.domain import Scale
from hitab_core.learning import Leaf
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.gain_ratio import TIE
from hitab_core.learning.splits import Chosen, Leaves, Split, choose_split, worthy_splits
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import Arc, nodes

NEARLY = 0.9
"""The least gain ratio, as a share of the best one, of a feature that explains nearly as well."""

POINT = 1e-6
"""Width of an arc, as a share of the circle, that is a single direction: nobody means one."""

Candidates = Sequence[Split | None]
Situation = tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Side:
    """One of two explanations.

    Attributes:
        next_state: what it decides in the situation asked about.
        because: the conditions that make it so, where the two explanations part.
        feature: index of the feature that it tests where the other one tests another.
    """

    next_state: str
    because: str
    feature: int


@dataclass(frozen=True)
class Ambiguity:
    """A question that one command answers.

    Attributes:
        state: the state whose decision it is about.
        learned: what the learned tree does at present.
        other: what an alternative would do.
        situation: a value for each feature; NaN: any.
        here: whether it was perceived in the state.
        share: how often the two differ, as a share of what was perceived in the state.
        features: names of the features.
        text: the question.
    """

    state: str
    learned: Side
    other: Side
    situation: Situation
    here: bool
    share: float
    features: tuple[str, ...]
    text: str

    @property
    def key(self) -> tuple[str, str, str, str, str]:
        """What makes it the same question again, though examples have been added meanwhile."""
        sides = sorted(
            (self.features[side.feature], side.next_state) for side in (self.learned, self.other)
        )
        return (self.state, *sides[0], *sides[1])


def ambiguities(
    evidence: Evidence, perceived: Sequence[tuple[str, Sequence[float]]] = ()
) -> list[Ambiguity]:
    """Return the questions about the examples of one state, the most useful first.

    There are none about other classifiers than trees. None of them is about a situation in which
    an earlier one is asked. Situations that were perceived in the state come first, then those of
    explanations that differ often.

    Args:
        evidence: the examples of the state.
        perceived: in this training: states with the features' values. Those of the examples are
            added.

    Raises:
        FeatureValueError, VocabularyError, ValueError: as learning from the examples.
    """
    learned, others = alternatives(evidence)
    if learned is None or not others:
        return []
    rows = [(True, tuple(row)) for row in evidence.values.tolist()]
    rows += [(state == evidence.state, evidence.placed(values)) for state, values in perceived]
    usual = SupportedTree(learned, evidence)
    found = []
    for tree in others:
        other = SupportedTree(tree, evidence)
        question = _question(usual, other, rows)
        if question is not None:
            found.append((question, other))
    found.sort(key=lambda item: (not item[0].here, -item[0].share))
    kept: list[Ambiguity] = []
    for question, other in found:
        if not any(_differ(usual, other, earlier.situation) for earlier in kept):
            kept.append(question)
    return kept


def alternatives(evidence: Evidence) -> tuple[TransitionTree | None, list[TransitionTree]]:
    """Return the tree that is learned, and its alternatives, those nearest to the root first.

    Raises:
        FeatureValueError, VocabularyError, ValueError: as `TransitionTree.fit`.
    """
    arguments = ClassifierSpec.parse(evidence.classifier).arguments
    boolean_first = bool(arguments.get("boolean_first", True))
    usual = _Choice(boolean_first)
    learned = evidence.learn(usual)
    if learned is None:
        return None, []
    leaves = _leaves(learned)
    others = []
    for changed, (candidates, chosen) in enumerate(usual.made):
        for feature in _rivals(candidates, chosen):
            tree = evidence.learn(_Choice(boolean_first, changed, feature))
            assert tree is not None
            its = _leaves(tree)
            if len(its) <= len(leaves) and _misfits(its) <= _misfits(leaves) + TIE:
                others.append(tree)
    return learned, others


class _Choice:
    """C4.5's choice, except that one node is split by a given feature.

    A tree is grown level by level, so all choices before the changed one stay what they are.
    """

    def __init__(self, boolean_first: bool, changed: int = -1, feature: int = 0) -> None:
        self._boolean_first = boolean_first
        self._changed, self._feature = changed, feature
        self.made: list[tuple[Candidates, Chosen | None]] = []

    def __call__(
        self, candidates: Candidates, scales: Sequence[Scale], leaves: Leaves | None
    ) -> Chosen | None:
        chosen = choose_split(candidates, scales, leaves, boolean_first=self._boolean_first)
        if len(self.made) == self._changed:
            split = candidates[self._feature]
            chosen = None if split is None else (self._feature, split)
        self.made.append((candidates, chosen))
        return chosen


def _rivals(candidates: Candidates, chosen: Chosen | None) -> list[int]:
    """Return the features that split a node nearly as well as the chosen one."""
    if chosen is None:
        return []
    worthy = worthy_splits(candidates)
    enough = NEARLY * max(split.ratio for _, split in worthy) - TIE
    return [
        f
        for f, split in worthy
        if f != chosen[0] and split.ratio >= enough and not _is_a_point(split)
    ]


def _is_a_point(split: Split) -> bool:
    """Return whether a split singles out one direction, between default examples on both sides."""
    test = split.test
    if not isinstance(test, Arc):
        return False
    width = (test.end - test.start) % test.period
    return min(width, test.period - width) < POINT * test.period


def _misfits(leaves: Sequence[Leaf]) -> float:
    """Return the number of examples that are not what their leaf decides."""
    return sum(sum(leaf.counts) - max(leaf.counts) for leaf in leaves)


def _leaves(tree: TransitionTree) -> list[Leaf]:
    return [node for node in nodes(tree.root_) if isinstance(node, Leaf)]


def _differ(some: SupportedTree, other: SupportedTree, values: Situation) -> bool:
    """Return whether two explanations surely and clearly decide otherwise in a situation."""
    a, b = some.decide(values), other.decide(values)
    if a is None or b is None or a.next_state == b.next_state:
        return False
    return a.sure and b.sure and a.clear and b.clear


def _question(
    usual: SupportedTree, other: SupportedTree, rows: Sequence[tuple[bool, Situation]]
) -> Ambiguity | None:
    """Return the question that two explanations give rise to, if they differ anywhere.

    It is asked in the middle one of the situations in which they differ, by their distance from
    an example: near one, the person has just said what to do, but too near one, the wrong
    explanation may only move its threshold.

    Args:
        usual, other: the explanations.
        rows: what was perceived, and whether in the state.
    """
    evidence = usual.evidence
    different = [(here, values) for here, values in rows if _differ(usual, other, values)]
    if not different:
        return None
    in_state = [values for here, values in different if here]
    features = sorted({*usual.tree.features_used, *other.tree.features_used})
    nearness = Nearness(evidence.values, evidence.scales, features)
    situations = dict.fromkeys(in_state or [values for _, values in different])
    nearest = sorted(situations, key=nearness)
    situation = nearest[len(nearest) // 2]
    decisions = [tree.decide(situation) for tree in (usual, other)]
    paths = [decision.path for decision in decisions if decision is not None]
    at = parting(*paths)
    learned, alternative = (
        _side(tree, decision, at)
        for tree, decision in zip((usual, other), decisions, strict=True)
        if decision is not None
    )
    where = situation_in_words(evidence, situation, features)
    return Ambiguity(
        evidence.state,
        learned,
        alternative,
        situation,
        bool(in_state),
        len(in_state) / sum(here for here, _ in rows),
        evidence.names,
        f"In {evidence.state} with {where}: {_what(learned, evidence)}, "
        f"or {_what(alternative, evidence)}?",
    )


def _side(tree: SupportedTree, decision: Decision, at: int) -> Side:
    path = decision.path[at:]
    return Side(decision.next_state, tree.words(path), path[0][0].feature)


def _what(side: Side, evidence: Evidence) -> str:
    doing = "stay" if side.next_state == evidence.state else f"go to {side.next_state}"
    return f"{doing}, because {side.because}"
