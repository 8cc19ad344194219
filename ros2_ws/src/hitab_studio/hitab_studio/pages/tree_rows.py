"""A transition tree as rows of a page: the tests, their outcomes and the path taken."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hitab_core import TransitionTree
from hitab_core.learning import Leaf, tree_text


@dataclass(frozen=True)
class Row:
    """A branch of a tree, see `hitab_core.learning.tree_text.rows`.

    Attributes:
        depth: depth of the branch, from 0.
        condition: condition of the branch; "" in a tree without tests.
        chances: at a leaf, probability and label of each next state, the most probable first.
        examples: at a leaf, the number of examples; not an integer if some lacked a value.
        taken: whether the shown decision took the branch.
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
        tree: the tree to show.
        names: names of the tree's features.
        values: known values of features, by name; `Row.taken` marks the decision for them.
    """
    rows = []
    for depth, condition, node, path in tree_text.rows(tree.root_, tree.scales_, names):
        taken = bool(values) and all(
            not math.isnan(value := values.get(names[fork.feature], math.nan))
            and fork.branch_for(value) == branch
            for fork, branch in path
        )
        is_leaf = isinstance(node, Leaf)
        odds = tree_text.distribution(node.counts, tree.labels) if is_leaf else {}
        chances = tuple(sorted(((p, label) for label, p in odds.items()), reverse=True))
        examples = tree_text.number_of(sum(node.counts)) if is_leaf else 0
        rows.append(Row(depth, condition, chances, examples, taken))
    return rows
