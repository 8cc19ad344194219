"""Decisions of a transition tree where the value of a tested feature is missing.

The question goes down every branch, and the answers count by the examples that went there in
training. A drawn decision goes down one of them by its draw instead, see
`compiled_tree.decider`; its distribution is the same.

Reference: J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from hitab_core.learning.tree_nodes import Leaf, Node
from hitab_core.texts.errors import NoValueError
from hitab_core.transition_function import Values

Likely = Callable[[Values, Callable[[int], float]], int]
"""``likely(values, read)`` returns the most probable state where values are missing."""

ValueOf = Callable[[int], float | None]
"""Returns a feature's value by its index; NaN if it is missing."""


def distribution_at(root: Node, value_of: ValueOf) -> list[float]:
    """Return the probability of each class.

    Args:
        root: the tree.
        value_of: returns a feature's value, or None if the decision did not read it: then all
            branches count as they did in training. Only relevant features are read.
    """
    odds = [0.0] * len(root.counts)
    waiting: list[tuple[Node, float]] = [(root, 1.0)]
    while waiting:
        node, share = waiting.pop()
        value = None if isinstance(node, Leaf) else value_of(node.feature)
        if isinstance(node, Leaf) or value is None:
            total = sum(node.counts)
            for i, n in enumerate(node.counts):
                odds[i] += share * (n / total)
        elif value == value:
            branch = node.branch_for(value)
            waiting.append((Leaf(node.counts) if branch is None else node.branches[branch], share))
        else:
            total = sum(node.counts)
            waiting += [(b, share * (sum(b.counts) / total)) for b in reversed(node.branches)]
    return odds


def likely_state(root: Node, slots: Sequence[int], states: Sequence[int]) -> Likely:
    """Return a function that finds the most probable state; on a tie, the lowest index.

    Args:
        root: the tree.
        slots: the slot of each feature's value.
        states: index of each class's state.
    """

    def likely(values: Values, read: Callable[[int], float]) -> int:
        def value_of(feature: int) -> float:
            value = values[slots[feature]]
            try:
                return read(slots[feature]) if value is None else value
            except NoValueError:
                return math.nan

        odds = distribution_at(root, value_of)
        return min(zip(odds, states, strict=True), key=lambda choice: (-choice[0], choice[1]))[1]

    return likely
