"""A transition tree as nested tuples: one kind of test, walked in a loop that allocates nothing.

Every test becomes ``low < value <= high``, after ``value %= period`` if there is a period, so that
one decision costs a fraction of a microsecond.

Where a value is missing, a decision goes down one branch by its draw, as often as examples went
there in training; the rest of the draw is uniform again and serves for the next one. So every
decision takes at most one draw.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from hitab_core.learning.missing_values import Likely
from hitab_core.learning.tree_nodes import Arc, Counts, Leaf, Node, Threshold, fold
from hitab_core.texts.errors import NoValueError
from hitab_core.transition_function import Decide, Values

Compiled = Any
"""``(slot, period, low, high, yes, no, share)``; at the end of a path, anything but a plain tuple.

``share`` is the fraction of the examples that went to ``yes`` in training.
"""

LARGEST_DRAW = math.nextafter(1.0, 0.0)
"""Maximum remainder of a draw: rounded, but below 1."""


class Draw(NamedTuple):
    """A leaf to draw from: ``choices[i]`` for the first ``cumulative[i]`` above the draw.

    The last cumulative probability is exactly 1, above any draw.
    """

    cumulative: list[float]
    choices: list[int]


def leaf_choice(
    counts: Sequence[float], states: Sequence[int], *, most_probable: bool = False
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
    below, cumulative = 0.0, []
    for _, n in present:
        below += n
        cumulative.append(below / total)
    cumulative[-1] = 1.0  # parts of examples may add up to a little less
    return Draw(cumulative, [state for state, _ in present])


def compiled(root: Node, slots: Sequence[int], leaf: Callable[[Counts], Any]) -> Compiled:
    """Return the tree as nested tuples.

    Args:
        root: the tree.
        slots: the slot of each feature's value.
        leaf: turns a leaf's counts into the end of a path; anything but a plain tuple.
    """

    def make(node: Node, parts: list[Compiled]) -> Compiled:
        if isinstance(node, Leaf):
            return leaf(node.counts)
        slot, test = slots[node.feature], node.test
        if isinstance(test, Threshold):
            return (slot, 0.0, -math.inf, test.threshold, *parts, _share(node.branches))
        if isinstance(test, Arc):
            return _arc(slot, test, node.branches, parts)
        sizes = [sum(branch.counts) for branch in node.branches]
        return _categories(slot, test.categories, parts, sizes, leaf(node.counts))

    return fold(root, make)


def _share(branches: Sequence[Node]) -> float:
    """Return the fraction of the examples of two branches that is in the first one."""
    first, second = (sum(branch.counts) for branch in branches)
    return first / (first + second)


def _arc(slot: int, arc: Arc, branches: Sequence[Node], parts: Sequence[Compiled]) -> Compiled:
    """Return the test of an arc, on whichever of its two sides does not contain zero.

    So neither zero nor ``period``, the same place, is in a tested arc: Python's remainder of a
    tiny negative value is ``period``.
    """
    low, high = arc.start, arc.end or arc.period
    if low == 0.0 or high < low:
        low, high = arc.end, arc.start or arc.period
        branches, parts = branches[::-1], parts[::-1]
    ends = math.nextafter(low, -math.inf), math.nextafter(high, -math.inf)
    return (slot, arc.period, *ends, *parts, _share(branches))


def _categories(
    slot: int,
    categories: Sequence[int],
    parts: Sequence[Compiled],
    sizes: Sequence[float],
    fallback: Compiled,
) -> Compiled:
    """Return a binary search over the ascending categories; no example went to ``fallback``."""
    if len(categories) == 1:
        return (slot, 0.0, categories[0] - 0.5, categories[0] + 0.5, parts[0], fallback, 1.0)
    half = len(categories) // 2
    return (
        slot,
        0.0,
        -math.inf,
        categories[half - 1] + 0.5,
        _categories(slot, categories[:half], parts[:half], sizes[:half], fallback),
        _categories(slot, categories[half:], parts[half:], sizes[half:], fallback),
        sum(sizes[:half]) / sum(sizes),
    )


def decider(root: Compiled, likely: Likely | None = None) -> Decide:
    """Return a function that decides for one agent.

    Args:
        root: a tree with `leaf_choice` leaves.
        likely: decides where a value is missing; None to decide by the draw.
    """

    def decide(values: Values, read: Callable[[int], float], draw: Callable[[], float]) -> int:
        node, drawn = root, -1.0
        while type(node) is tuple:
            slot, period, low, high, yes, no, share = node
            value = values[slot]
            if value is None:
                try:
                    value = read(slot)
                except NoValueError:
                    value = math.nan
            if period:
                value %= period
            if low < value <= high:
                node = yes
            elif value == value:
                node = no
            elif likely is not None:
                return likely(values, read)
            else:
                if drawn < 0.0:
                    drawn = draw()
                if drawn < share:
                    node, drawn = yes, drawn / share
                else:
                    node, drawn = no, min((drawn - share) / (1.0 - share), LARGEST_DRAW)
        if type(node) is int:
            return node
        if drawn < 0.0:
            drawn = draw()
        return node[1][bisect_right(node[0], drawn)]  # type: ignore[no-any-return]

    return decide
