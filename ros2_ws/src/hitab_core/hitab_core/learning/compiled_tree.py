"""A transition tree as nested tuples: one kind of test, walked in a loop that allocates nothing.

Every test becomes ``low < value <= high``, after ``value %= period`` where there is a period, so
that one decision costs a fraction of a microsecond. One walk decides for one agent, the other for
many at once by exactly the same comparisons.
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
"""``(slot, period, low, high, yes, no)``, or at the end of a path anything but a plain tuple."""


class Draw(NamedTuple):
    """A leaf to draw from: ``choices[i]`` if the draw is below ``cumulative[i]`` and not before.

    The last cumulative probability is exactly 1, above any draw.
    """

    cumulative: list[float]
    choices: list[int]


def leaf_choice(
    counts: Sequence[int], states: Sequence[int], *, most_probable: bool = False
) -> int | Draw:
    """Return the state of a leaf, or what to draw it from.

    Args:
        counts: examples of each class, not all 0.
        states: for each class, the index of its state. States are drawn in this order, so that
            the same draws give the same states however the classes are ordered.
        most_probable: return the most probable state; of equal ones that with the lowest index.
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
        slots: for each feature, the slot that its value will be in.
        leaf: makes what stands at the end of a path of its counts; anything but a plain tuple.
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
    """Return the test of an arc, as that of the one of its two sides that zero is not in.

    Zero is then in no tested arc, nor is ``period``, which Python's remainder of a tiny negative
    value is: both are the same place.
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
    """Return a binary search among the categories, which are in ascending order."""
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
    """Return the decision of a compiled tree with `leaf_choice` leaves, for one agent."""

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
        """Return those of some agents that have a value in a slot, and their values."""


class MatrixColumns:
    """The columns of an array, shape (n, m), without missing values."""

    def __init__(self, X: Floats) -> None:
        self._X = X

    def take(self, slot: int, rows: Integers) -> tuple[Integers, Floats]:
        """Return the rows, and their values."""
        return rows, self._X[rows, slot]


def ends(root: Compiled, columns: Columns, rows: Integers) -> Iterator[tuple[Any, Integers]]:
    """Yield the ends of paths that agents come to, with the indices of these agents.

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
    """Return the decisions of a compiled tree with `leaf_choice` leaves, for many agents at once.

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
