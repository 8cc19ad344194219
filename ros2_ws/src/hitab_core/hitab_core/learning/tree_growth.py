"""Growing a transition tree from examples, top down, as C4.5 does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hitab_core.arrays import Booleans, Floats, Integers
from hitab_core.domain import Scale
from hitab_core.learning.gain_ratio import TIE
from hitab_core.learning.splits import (
    Arc,
    Categories,
    Choose,
    Examples,
    Split,
    choose_split,
    split_by,
)
from hitab_core.learning.tree_nodes import ArcNode, CategoryNode, Leaf, Node, ThresholdNode


@dataclass(slots=True)
class _Place:
    """A node under construction: its examples and, once split, its split and branches."""

    rows: Integers
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
    choose: Choose = choose_split,
) -> Node:
    """Return the root of a tree that separates all examples that differ.

    A node is split even if no single split gains anything, as when two features matter only
    together (one true, the other false), so that no demonstration is ignored. It is not split if
    no further splits could gain either: if every point has the node's class proportions.

    Args:
        X: shape (n, m), the values; toroidal ones in [0, period).
        classes: shape (n,), classes as 0 .. n_classes - 1.
        default: shape (n,), whether an example is a default one.
        n_classes: number of classes.
        scales: how the values of each of the m features compare.
        min_samples_leaf: the fewest examples a branch may have; for a categorical feature, at
            least two branches must have as many.
        max_depth: the most tests on a path.
        choose: chooses among the features' best splits, once for each node that has several
            classes, level by level, and on a level in the order of the branches.
    """
    places = [_Place(np.arange(len(X)), 0)]
    for place in places:  # the list grows during this loop
        rows = place.rows
        if place.depth == max_depth or len(np.unique(classes[rows])) < 2:
            continue
        candidates = [
            split_by(
                Examples(X[rows, f], classes[rows], default[rows], n_classes),
                scale,
                min_samples_leaf,
            )
            for f, scale in enumerate(scales)
        ]
        chosen = choose(candidates, scales)
        if chosen is None:
            continue
        feature, split = chosen
        if split.gain <= TIE and not _points_differ(X[rows], classes[rows], n_classes):
            continue
        place.feature, place.split = feature, split
        place.branches = list(range(len(places), len(places) + len(split.parts)))
        places.extend(_Place(rows[part], place.depth + 1) for part in split.parts)

    made: dict[int, Node] = {}
    for index in range(len(places) - 1, -1, -1):  # branches come after their node
        place = places[index]
        counts = tuple(np.bincount(classes[place.rows], minlength=n_classes).tolist())
        made[index] = _node(place, counts, [made.pop(branch) for branch in place.branches])
    return made[0]


def _points_differ(X: Floats, classes: Integers, n_classes: int) -> bool:
    """Return whether the class proportions at some distinct point of X differ from the rest."""
    points, point_of = np.unique(X, axis=0, return_inverse=True)
    counts = np.zeros((len(points), n_classes), np.int64)
    np.add.at(counts, (point_of.reshape(-1), classes), 1)
    expected = np.outer(counts.sum(axis=1), counts.sum(axis=0))
    return not np.array_equal(counts * len(X), expected)


def _node(place: _Place, counts: tuple[int, ...], branches: list[Node]) -> Node:
    if place.split is None:
        return Leaf(counts)
    test = place.split.test
    if isinstance(test, Categories):
        return CategoryNode(place.feature, test.categories, counts, tuple(branches))
    if isinstance(test, Arc):
        return ArcNode(place.feature, test.period, test.start, test.end, counts, *branches)
    return ThresholdNode(place.feature, test.threshold, counts, *branches)
