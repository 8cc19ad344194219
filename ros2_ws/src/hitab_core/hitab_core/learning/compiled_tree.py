"""A transition tree as nested tuples: one kind of test, walked in a loop that allocates nothing.

Every test becomes ``low < value <= high``, after ``value %= period`` if there is a period, so that
one decision costs a fraction of a microsecond. One walk decides for a single agent, the other for
many agents at once, with exactly the same comparisons.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from hitab_core.arrays import Floats, Integers
from hitab_core.learning.tree_nodes import ArcNode, Leaf, Node, ThresholdNode, fold
from hitab_core.transition_function import Decide, Values

Compiled = Any
"""``(slot, period, low, high, yes, no)``; at the end of a path, anything but a plain tuple."""


class Draw(NamedTuple):
    """A leaf to draw from: ``choices[i]`` for the first ``cumulative[i]`` above the draw.

    The last cumulative probability is exactly 1, above any draw.
    """

    cumulative: list[float]
    choices: list[int]


def leaf_choice(
    counts: Sequence[int], states: Sequence[int], *, most_probable: bool = False
) -> int | Draw:
    """Return the state of a leaf, or the distribution to draw it from.

    Args:
        counts: number of examples of each class, not all 0.
        states: index of each class's state. States are drawn in this order, so that the same draws
            give the same states whatever the order of the classes.
        most_probable: return the most probable state; on a tie, the lowest index.
    """
    present = sorted((state, n) for state, n in zip(states, counts, strict=True) if n)
    if most_probable:
        return min(present, key=lambda choice: (-choice[1], choice[0]))[0]
    if len(present) == 1:
        return present[0][0]
    total = sum(n for _, n in present)
    below, cumulative = 0, []
    for _, n in present:
        below += n
        cumulative.append(below / total)
    return Draw(cumulative, [state for state, _ in present])


def compiled(root: Node, slots: Sequence[int], leaf: Callable[[tuple[int, ...]], Any]) -> Compiled:
    """Return the tree as nested tuples.

    Args:
        root: the tree.
        slots: the slot of each feature's value.
        leaf: turns a leaf's counts into the end of a path; anything but a plain tuple.
    """

    def make(node: Node, parts: list[Compiled]) -> Compiled:
        if isinstance(node, Leaf):
            return leaf(node.counts)
        slot = slots[node.feature]
        if isinstance(node, ThresholdNode):
            return (slot, 0.0, -math.inf, node.threshold, *parts)
        if isinstance(node, ArcNode):
            return _arc(slot, node, *parts)
        return _categories(slot, node.categories, parts, leaf(node.counts))

    return fold(root, make)


def _arc(slot: int, node: ArcNode, inside: Compiled, outside: Compiled) -> Compiled:
    """Return the test of an arc, on whichever of its two sides does not contain zero.

    So neither zero nor ``period``, the same place, is in a tested arc: Python's remainder of a
    tiny negative value is ``period``.
    """
    low, high, yes, no = node.start, node.end or node.period, inside, outside
    if low == 0.0 or high < low:
        low, high, yes, no = node.end, node.start or node.period, outside, inside
    return (
        slot,
        node.period,
        math.nextafter(low, -math.inf),
        math.nextafter(high, -math.inf),
        yes,
        no,
    )


def _categories(
    slot: int, categories: Sequence[int], parts: Sequence[Compiled], fallback: Compiled
) -> Compiled:
    """Return a binary search over the ascending categories."""
    if len(categories) == 1:
        return (slot, 0.0, categories[0] - 0.5, categories[0] + 0.5, parts[0], fallback)
    half = len(categories) // 2
    return (
        slot,
        0.0,
        -math.inf,
        categories[half - 1] + 0.5,
        _categories(slot, categories[:half], parts[:half], fallback),
        _categories(slot, categories[half:], parts[half:], fallback),
    )


def decider(root: Compiled) -> Decide:
    """Return a function that decides for one agent, from a tree with `leaf_choice` leaves."""

    def decide(values: Values, read: Callable[[int], float], draw: Callable[[], float]) -> int:
        node = root
        while type(node) is tuple:
            slot, period, low, high, yes, no = node
            value = values[slot]
            if value is None:
                value = read(slot)
            if period:
                value %= period
            node = yes if low < value <= high else no
        if type(node) is int:
            return node
        return node[1][bisect_right(node[0], draw())]  # type: ignore[no-any-return]

    return decide


class Columns(Protocol):
    """Where the values of many agents come from."""

    def take(self, slot: int, rows: Integers) -> tuple[Integers, Floats]:
        """Return the agents among ``rows`` that have a value in a slot, and their values."""


class MatrixColumns:
    """The columns of an array, shape (n, m), without missing values."""

    def __init__(self, X: Floats) -> None:
        self._X = X

    def take(self, slot: int, rows: Integers) -> tuple[Integers, Floats]:
        """Return the rows, and their values."""
        return rows, self._X[rows, slot]


def ends(root: Compiled, columns: Columns, rows: Integers) -> Iterator[tuple[Any, Integers]]:
    """Yield the path ends that agents reach, with the indices of these agents.

    Args:
        root: a compiled tree.
        columns: the agents' values, by the slots of the tree.
        rows: the agents.
    """
    waiting: list[tuple[Compiled, Integers]] = [(root, rows)]
    while waiting:
        node, rows = waiting.pop()
        if not len(rows):
            continue
        if type(node) is not tuple:
            yield node, rows
            continue
        slot, period, low, high, yes, no = node
        rows, values = columns.take(slot, rows)
        if period:
            values = values % period
        held = values <= high
        if low != -math.inf:
            held &= low < values
        n_held = np.count_nonzero(held)
        if n_held < len(rows):
            waiting.append((no, rows[~held] if n_held else rows))
        if n_held:
            waiting.append((yes, rows[held] if n_held < len(rows) else rows))


def decide_rows(root: Compiled, X: Floats, draws: Floats) -> Integers:
    """Decide for many agents at once, with a tree with `leaf_choice` leaves.

    Args:
        root: the compiled tree, its slots columns of X.
        X: shape (n, m), values without missing ones.
        draws: shape (n,), uniform on [0, 1).
    """
    chosen = np.empty(len(X), np.int64)
    for leaf, rows in ends(root, MatrixColumns(X), np.arange(len(X))):
        if isinstance(leaf, Draw):
            drawn = np.searchsorted(leaf.cumulative, draws[rows], side="right")
            chosen[rows] = np.asarray(leaf.choices)[drawn]
        else:
            chosen[rows] = leaf
    return chosen
