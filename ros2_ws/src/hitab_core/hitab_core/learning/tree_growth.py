"""Growing a transition tree from examples, top down, as C4.5 does.

An example without a value of the tested feature goes into every branch, in each with the fraction
of the others that is there. So an example may be in a node only in part, and counts there as that
part.

Reference: J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hitab_core.domain import Scale
from hitab_core.learning.gain_ratio import TIE
from hitab_core.learning.splits import (
    Choose,
    Chosen,
    Examples,
    Leaves,
    Split,
    choose_split,
    split_by,
)
from hitab_core.learning.tree_nodes import Fork, Leaf, Node, nodes
from hitab_core.numeric.arrays import Booleans, Floats, Integers

LEAST_FRACTION = 1 / 128
"""The smallest part of an example for which a branch is made, if one example is enough for one.

C4.5 asks for two whole examples per branch, so that a tree has at most half as many leaves as
examples, however many values are missing. Here two demonstrations differ even if one of them is in
a node only in part, and this number limits the leaves.
"""


AHEAD_MAX = 100
"""The most examples of a node for which trees below it are compared; people give fewer."""


class _First:
    """Chooses a given split of the root, and others without looking ahead."""

    def __init__(self, chosen: Chosen) -> None:
        self._chosen: Chosen | None = chosen

    def __call__(
        self, candidates: Sequence[Split | None], scales: Sequence[Scale], leaves: Leaves | None
    ) -> Chosen | None:
        chosen, self._chosen = self._chosen, None
        return chosen or choose_split(candidates, scales)


@dataclass(slots=True)
class _Place:
    """A node under construction: its examples and, once split, its split and branches.

    ``weights`` are the fractions of the examples that are here; None for all of each.
    """

    rows: Integers
    weights: Floats | None
    depth: int
    split: Split | None = None
    feature: int = 0
    branches: list[int] = field(default_factory=list)


def grow(
    X: Floats,
    classes: Integers,
    default: Booleans,
    n_classes: int,
    scales: Sequence[Scale],
    *,
    min_samples_leaf: int = 1,
    max_depth: int | None = None,
    all_around: bool = False,
    look_ahead: bool = True,
    choose: Choose = choose_split,
) -> Node:
    """Return the root of a tree that separates all examples that differ.

    A node is split even if no single split gains anything, as when two features matter only
    together (one true, the other false), so that no demonstration is ignored. It is not split if
    no further splits could gain either: if every point has the node's class proportions.

    Args:
        X: shape (n, m), the values; toroidal ones in [0, period); NaN if missing.
        classes: shape (n,), classes as 0 .. n_classes - 1.
        default: shape (n,), whether an example is a default one.
        n_classes: number of classes.
        scales: scale of each of the m features.
        min_samples_leaf: the fewest examples, parts added up, with a known value that a branch may
            have; for a categorical feature, at least two branches must have as many. 1: any, see
            `LEAST_FRACTION`.
        max_depth: the most tests on a path.
        all_around: see `hitab_core.learning.splits.split_toroidal`.
        look_ahead: whether ``choose`` can compare the trees that its choices lead to, where no
            value is missing and there are at most `AHEAD_MAX` examples.
        choose: chooses among the features' best splits, once for each node that has several
            classes, level by level, and on a level in the order of the branches.
    """

    def leaves(rows: Integers, depth: int) -> Leaves | None:
        if not look_ahead or len(rows) > AHEAD_MAX or missing[rows].any():
            return None

        def count(chosen: Chosen) -> int:
            root = grow(
                X[rows],
                classes[rows],
                default[rows],
                n_classes,
                scales,
                min_samples_leaf=min_samples_leaf,
                max_depth=None if max_depth is None else max_depth - depth,
                all_around=all_around,
                look_ahead=False,
                choose=_First(chosen),
            )
            return sum(isinstance(node, Leaf) for node in nodes(root))

        return count

    missing = np.isnan(X)
    places = [_Place(np.arange(len(X)), None, 0)]
    for place in places:  # the list grows during this loop
        rows = place.rows
        if place.depth == max_depth or len(np.unique(classes[rows])) < 2:
            continue
        fewest: float = min_samples_leaf
        if place.weights is not None and min_samples_leaf == 1:
            fewest = LEAST_FRACTION
        candidates = [
            split_by(
                _seen_through(place, X[:, f], classes, default, n_classes),
                scale,
                fewest,
                all_around=all_around,
            )
            for f, scale in enumerate(scales)
        ]
        chosen = choose(candidates, scales, leaves(rows, place.depth))
        if chosen is None:
            continue
        feature, split = chosen
        if split.gain <= TIE and not _points_differ(
            X[rows], classes[rows], n_classes, place.weights
        ):
            continue
        place.feature, place.split = feature, split
        place.branches = list(range(len(places), len(places) + len(split.parts)))
        places.extend(_branches(place, missing[rows, feature], split.parts))

    made: dict[int, Node] = {}
    for index in range(len(places) - 1, -1, -1):  # branches come after their node
        place = places[index]
        counts = tuple(
            np.bincount(classes[place.rows], place.weights, minlength=n_classes).tolist()
        )
        branches = tuple(made.pop(branch) for branch in place.branches)
        made[index] = Leaf(counts)
        if place.split is not None:
            made[index] = Fork(place.feature, place.split.test, counts, branches)
    return made[0]


def _seen_through(
    place: _Place, column: Floats, classes: Integers, default: Booleans, n_classes: int
) -> Examples:
    """Return the examples of a place that have a value in a column of X."""
    rows, weights, unknown = place.rows, place.weights, 0.0
    values = column[rows]
    known = values == values
    if not known.all():
        unknown = _total(weights, ~known)
        rows, values = rows[known], values[known]
        weights = None if weights is None else weights[known]
    return Examples(values, classes[rows], default[rows], n_classes, weights, unknown)


def _total(weights: Floats | None, those: Booleans) -> float:
    """Return a number of examples, rounded once to be the same on all machines."""
    if weights is None:
        return float(np.count_nonzero(those))
    return math.fsum(weights[those].tolist())


def _branches(place: _Place, unknown: Booleans, parts: tuple[Integers, ...]) -> list[_Place]:
    """Return the branches of a place.

    Args:
        place: the place to split.
        unknown: mask of the examples without a value of the tested feature.
        parts: the positions of each branch's examples among the others.
    """
    rows, weights, depth = place.rows, place.weights, place.depth + 1
    if not unknown.any():
        return [
            _Place(rows[part], None if weights is None else _whole_or(weights[part]), depth)
            for part in parts
        ]
    known = np.flatnonzero(~unknown)
    if weights is None:
        weights = np.ones(len(rows))
    everybody = _total(weights, ~unknown)
    made = []
    for part in parts:
        here = unknown.copy()
        here[known[part]] = True
        fraction = _total(weights, here & ~unknown) / everybody
        share = np.where(unknown, weights * fraction, weights)[here]
        made.append(_Place(rows[here], share, depth))
    return made


def _whole_or(weights: Floats) -> Floats | None:
    """Return the weights, None if all examples are here as a whole."""
    return None if (weights == 1.0).all() else weights


def _points_differ(
    X: Floats, classes: Integers, n_classes: int, weights: Floats | None = None
) -> bool:
    """Return whether the class proportions at some distinct point of X differ from the rest.

    Where values are missing, only examples that have all, or features of which all have a value,
    are compared: no test separates examples by missing values.
    """
    missing = np.isnan(X)
    if missing.any():
        complete = ~missing.any(axis=1)
        return _points_differ(
            X[complete],
            classes[complete],
            n_classes,
            None if weights is None else weights[complete],
        ) or _points_differ(X[:, ~missing.any(axis=0)], classes, n_classes, weights)
    points, point_of = np.unique(X, axis=0, return_inverse=True)
    place = (point_of.reshape(-1), classes)
    if weights is None:
        counts = np.zeros((len(points), n_classes), np.int64)
        np.add.at(counts, place, 1)
        return not np.array_equal(
            counts * len(X), np.outer(counts.sum(axis=1), counts.sum(axis=0))
        )
    parts = np.zeros((len(points), n_classes))
    np.add.at(parts, place, weights)
    expected = np.outer(parts.sum(axis=1), parts.sum(axis=0)) / parts.sum()
    return not np.allclose(parts, expected, rtol=TIE, atol=0.0)
