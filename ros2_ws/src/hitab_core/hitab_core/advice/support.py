"""How near the examples that a tree was learned from come to each of its tests.

A boundary lies somewhere between two examples. What a tree decides for a value between them says
more about where boundaries are placed than about what the examples mean, so a decision counts as
*clear* only if the value is well on its side of each test: at least three fifths of the way
from the nearest example of the other side to the nearest one of its own, or beyond that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hitab_core.advice.evidence import Evidence
from hitab_core.arrays import Booleans, Floats
from hitab_core.domain import FeatureKind
from hitab_core.learning import Leaf, Node, tree_text
from hitab_core.learning.boundaries import on_circle
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.learning.tree_nodes import Arc, Fork, Threshold
from hitab_core.learning.tree_text import Step
from hitab_core.wording import DEGREES

CLEAR = 0.6
"""How far from the other side's nearest example a clear value is, in gaps between the sides."""

SURE = 2 / 3
"""The least probability of a next state that is a decision rather than a draw."""


@dataclass(frozen=True, slots=True)
class Decision:
    """What a tree decides in a situation.

    Attributes:
        next_state: the most probable one.
        sure: whether it has at least the probability `SURE`.
        clear: whether the situation is well on its side of each test on the path.
        path: the tests on the path, with the branch taken.
    """

    next_state: str
    sure: bool
    clear: bool
    path: tuple[Step, ...]


class SupportedTree:
    """A tree with how near its examples come to each test.

    Attributes:
        tree: the tree.
        evidence: what it was learned from.
    """

    def __init__(self, tree: TransitionTree, evidence: Evidence) -> None:
        self.tree = tree
        self.evidence = evidence
        self._gaps: dict[int, list[tuple[float, float]]] = {}
        waiting = [(tree.root_, np.ones(len(evidence.next_states), np.bool_))]
        while waiting:
            node, there = waiting.pop()
            if not isinstance(node, Leaf):
                column = evidence.values[:, node.feature]
                self._gaps[id(node)] = _gaps(node, column, there)
                branch_of = [None if v != v else node.branch_for(v) for v in column.tolist()]
                lacking = np.isnan(column)  # which is in every branch
                for i, branch in enumerate(node.branches):
                    here = np.array([of == i for of in branch_of], np.bool_)
                    waiting.append((branch, there & (here | lacking)))

    def decide(self, values: Sequence[float]) -> Decision | None:
        """Return what the tree decides; None if it tests a value that is missing (NaN)."""
        node = self.tree.root_
        path: list[Step] = []
        clear = True
        while not isinstance(node, Leaf):
            value = values[node.feature]
            if math.isnan(value):
                return None
            branch = node.branch_for(value)
            clear = clear and self._is_clear(node, branch, value)
            path.append((node, branch))
            node = node.branches[branch] if branch is not None else Leaf(node.counts)
        largest = max(node.counts)
        return Decision(
            self.tree.labels[node.counts.index(largest)],
            largest >= SURE * sum(node.counts),
            clear,
            tuple(path),
        )

    def words(self, path: Sequence[Step]) -> str:
        """Return the conditions on a path with their units, such as ``Range <= 2 m and Far``."""
        evidence = self.evidence
        units = [_unit(evidence, feature) for feature in range(len(evidence.names))]
        return " and ".join(tree_text.conditions(path, evidence.scales, evidence.names, units))

    def _is_clear(self, node: Node, branch: int | None, value: float) -> bool:
        test = node.test if isinstance(node, Fork) else None
        if isinstance(test, Threshold):
            ((low, high),) = self._gaps[id(node)]
            gap = high - low
            return value - low <= (1 - CLEAR) * gap if branch == 0 else value - low >= CLEAR * gap
        if isinstance(test, Arc):
            for (before, after), leads_to in zip(self._gaps[id(node)], (0, 1), strict=True):
                gap = (after - before) % test.period
                passed = on_circle(value - before, test.period)
                near = CLEAR * gap <= passed if branch == leads_to else passed <= (1 - CLEAR) * gap
                if passed < gap and not near:
                    return False
            return True
        return branch is not None


def parting(some: Sequence[Step], other: Sequence[Step]) -> int:
    """Return the index of the first test in which two paths differ."""
    for i, ((a, _), (b, _)) in enumerate(zip(some, other, strict=False)):
        if (a.feature, a.test) != (b.feature, b.test):
            return i
    return min(len(some), len(other))


def situation_in_words(
    evidence: Evidence, values: Sequence[float], features: Sequence[int]
) -> str:
    """Return values in words, such as ``Range = 2 m, not Far``; without those that are NaN."""
    texts = []
    for f in features:
        value, name, scale = values[f], evidence.names[f], evidence.scales[f]
        if math.isnan(value):
            continue
        if scale.kind is FeatureKind.BOOLEAN:
            texts.append(name if value else f"not {name}")
        elif scale.kind is FeatureKind.CATEGORICAL:
            known = dict(enumerate(scale.categories))
            texts.append(f"{name} = {known.get(int(value), f'{value:.6g}')}")
        else:
            half = scale.kind is FeatureKind.TOROIDAL and value > scale.period / 2
            number = value - scale.period if half else value
            unit = _unit(evidence, f)
            if tree_text.in_degrees(scale):
                number, unit = round(math.degrees(number), 1) + 0.0, DEGREES
            texts.append(f"{name} = {number:.6g}{f' {unit}' if unit else ''}")
    return ", ".join(texts)


def _unit(evidence: Evidence, feature: int) -> str:
    return evidence.units[feature] if evidence.scales[feature].kind.is_measured else ""


def _gaps(node: Node, column: Floats, there: Booleans) -> list[tuple[float, float]]:
    """Return the nearest examples on both sides of a threshold, or of the two ends of an arc.

    The first end of an arc leads inside, the second one outside.
    """
    values = np.unique(column[there & ~np.isnan(column)])
    test = node.test if isinstance(node, Fork) else None
    if isinstance(test, Threshold):
        low, high = values[values <= test.threshold], values[values > test.threshold]
        return [(low.max(initial=-math.inf), high.min(initial=math.inf))]
    if isinstance(test, Arc):
        return [_around(values, end, test.period) for end in (test.start, test.end)]
    return []


def _around(values: Floats, end: float, period: float) -> tuple[float, float]:
    """Return the last value before a place on the circle, and the first at or after it."""
    from_end = (values - end) % period
    return float(values[from_end.argmax()]), float(values[from_end.argmin()])
