"""C4.5's pessimistic pruning: a subtree that is not worth its size becomes a leaf."""

from __future__ import annotations

import math
from dataclasses import replace
from statistics import NormalDist

from hitab_core.learning.tree_nodes import Leaf, Node, fold


def pessimistic_errors(errors: float, n: float, confidence: float) -> float:
    """Return a pessimistic error count for a leaf that gets ``errors`` < ``n`` of ``n`` wrong.

    This is ``n`` times the upper limit of the error rate: the true rate is higher with probability
    ``confidence``. It is C4.5's approximation (normal, continuity-corrected; exact without
    errors), except that the normal quantile is exact; C4.5 interpolates in a table.
    Where values are missing, numbers need not be whole: below one error, and where all but half an
    example are wrong, it is C4.5's interpolation.

    References:
        J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapter 4 and
        ``stats.c`` of its release 8.
    """
    if errors < 1:
        without = n * (1.0 - math.pow(confidence, 1.0 / n))
        if errors == 0:
            return without
        return without + errors * (pessimistic_errors(1, n, confidence) - without)
    if errors + 0.5 >= n:
        return errors + 0.67 * (n - errors)
    z2 = NormalDist().inv_cdf(1.0 - confidence) ** 2
    observed = errors + 0.5
    limit = observed + z2 / 2 + math.sqrt(z2 * (observed * (1 - observed / n) + z2 / 4))
    return n * limit / (n + z2)


def prune(root: Node, confidence: float = 0.25) -> Node:
    """Return the tree with subtrees replaced by leaves that are not expected to be worse.

    From the leaves upwards, a node becomes a leaf if the leaf's pessimistic errors exceed those of
    the subtree by no more than 0.1, as in C4.5. Subtree raising is not done.

    Args:
        root: the tree.
        confidence: number in (0, 0.5]; smaller values prune more.
    """

    def pruned(node: Node, parts: list[tuple[Node, float]]) -> tuple[Node, float]:
        n = sum(node.counts)
        as_leaf = pessimistic_errors(n - max(node.counts), n, confidence)
        as_tree = sum(errors for _, errors in parts)
        if isinstance(node, Leaf) or as_leaf <= as_tree + 0.1:
            return Leaf(node.counts), as_leaf
        return replace(node, branches=tuple(branch for branch, _ in parts)), as_tree

    return fold(root, pruned)[0]
