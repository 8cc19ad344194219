"""Other trees that explain the examples of a state as well as the one that was learned.

C4.5 splits a node by the feature with the largest gain ratio. With few examples several features
often come out equal or nearly so, and then a tie rule or a little noise decides what the robot
does. An *alternative* is the tree that grows if one node is split by such another feature. It must
be as good an explanation:

- the other feature is one that C4.5 would have considered (at least average gain), and its gain
  ratio is at least `NEARLY` of the best one;
- the tree fits as many examples, and has no more leaves. Of explanations that fit equally well
  the shorter one is better, so one that needs more leaves is no rival.

References:
    J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapter 2.
    T. M. Mitchell, Generalization as search, Artificial Intelligence 18, 1982: what consistent
    hypotheses disagree on is what to ask about.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import TypeVar

from hitab_core.advice.evidence import Evidence
from hitab_core.domain import Scale
from hitab_core.learning import Leaf
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.gain_ratio import TIE
from hitab_core.learning.splits import Arc, Chosen, Leaves, Split, choose_split, worthy_splits
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import nodes

NEARLY = 0.9
"""The least gain ratio, as a share of the best one, of a feature that explains nearly as well."""

POINT = 1e-6
"""Width of an arc, as a share of the circle, that is a single direction: nobody means one."""

Candidates = Sequence[Split | None]


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


T = TypeVar("T")


def finished(steps: Generator[None, None, T]) -> T:
    """Return the result of something that is done in steps, with nothing done in between."""
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value  # type: ignore[no-any-return]


def growing_alternatives(
    evidence: Evidence,
) -> Generator[None, None, tuple[TransitionTree | None, list[TransitionTree]]]:
    """Return the tree that is learned from examples, and its alternatives, nearest the root first.

    There are none where another classifier is learned. Something else can be done between two
    trees.

    Raises:
        FeatureValueError, VocabularyError, ValueError: as `TransitionTree.fit`.
    """
    arguments = ClassifierSpec.parse(evidence.classifier).arguments
    boolean_first = bool(arguments.get("boolean_first", True))
    usual = _Choice(boolean_first)
    yield
    learned = evidence.learn(usual)
    if learned is None:
        return None, []
    leaves = _leaves(learned)
    others = []
    for changed, (candidates, chosen) in enumerate(usual.made):
        for feature in _rivals(candidates, chosen):
            yield
            tree = evidence.learn(_Choice(boolean_first, changed, feature))
            assert tree is not None
            its = _leaves(tree)
            if len(its) <= len(leaves) and _misfits(its) <= _misfits(leaves) + TIE:
                others.append(tree)
    return learned, others


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
