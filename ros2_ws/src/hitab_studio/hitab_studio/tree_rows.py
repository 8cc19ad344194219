"""A transition tree as rows of a page: the tests, their outcomes and the path taken."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hitab_core import TransitionTree
from hitab_core.learning import Leaf, Node, tree_text


@dataclass(frozen=True)
class Row:
    """One branch.

    Attributes:
        depth: from 0.
        condition: of the branch; "" in a tree without tests.
        chances: at a leaf, probability and label of each next state, the most probable first.
        examples: at a leaf, the number of its examples; not whole if some lacked a value.
        taken: whether the shown decision took it.
    """

    depth: int
    condition: str
    chances: tuple[tuple[float, str], ...]
    examples: float
    taken: bool


def tree_rows(
    tree: TransitionTree, names: Sequence[str], values: Mapping[str, float]
) -> list[Row]:
    """Return the rows of a tree.

    Args:
        tree: to show.
        names: of its features.
        values: of those features that are known, by name; the decision for them is shown.
    """
    rows: list[Row] = []

    def leaf(node: Node) -> tuple[tuple[float, str], ...]:
        odds = tree_text.distribution(node.counts, tree.labels)
        return tuple(sorted(((p, label) for label, p in odds.items()), reverse=True))

    waiting: list[tuple[Node, int, str, bool]] = [(tree.root_, 0, "", bool(values))]
    while waiting:
        node, depth, condition, taken = waiting.pop()
        if isinstance(node, Leaf):
            rows.append(
                Row(depth, condition, leaf(node), tree_text.number_of(sum(node.counts)), taken)
            )
            continue
        if condition:
            rows.append(Row(depth, condition, (), 0, taken))
        value = values.get(names[node.feature], math.nan)
        chosen = node.branch_for(value) if taken and not math.isnan(value) else None
        inner = depth + 1 if condition else depth
        for i in reversed(range(len(node.branches))):
            words = tree_text.conditions([(node, i)], tree.scales_, names)[0]
            waiting.append((node.branches[i], inner, words, chosen == i))
    return rows
