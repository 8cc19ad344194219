"""Information gain and gain ratio, from the number of examples of each class per branch.

Reference: J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapter 2.
"""

from __future__ import annotations

import numpy as np

from hitab_core.arrays import Floats, Integers

TIE = 1e-9
"""Gains (in bits) and gain ratios that differ by less than this count as equal."""


def _n_log_n(largest: int) -> Floats:
    """Return a table of ``n log2 n`` for n from 0 to ``largest``."""
    n = np.arange(largest + 1, dtype=np.float64)
    n[1:] *= np.log2(n[1:])
    return n


def gain_and_ratio(counts: Integers) -> tuple[float, float]:
    """Return information gain (bits) and gain ratio of a split.

    Args:
        counts: shape (n_branches, n_classes), examples of each class in each branch.
    """
    sizes = counts.sum(axis=1)
    n = int(sizes.sum())
    table = _n_log_n(n)
    before = table[n] - table[counts.sum(axis=0)].sum()
    after = table[sizes].sum() - table[counts].sum()
    split_information = table[n] - table[sizes].sum()
    gain = max(0.0, float(before - after) / n)
    return gain, gain * n / float(split_information) if split_information > 0 else 0.0


def two_way_gains(inside: Integers, totals: Integers, min_branch: int) -> tuple[Floats, Integers]:
    """Return each two-way split's gain, up to a constant, and the size of its smaller side.

    Args:
        inside: shape (n_classes, ...), examples of each class in each split's first branch.
        totals: shape (n_classes,), the examples of each class in the node.
        min_branch: the fewest examples a branch may have; with fewer the gain is -inf.
    """
    n = int(totals.sum())
    table = _n_log_n(n)
    sizes = inside.sum(axis=0)
    gains = -table[sizes] - table[n - sizes]
    for own, total in zip(inside, totals.tolist(), strict=True):
        gains += table[own] + table[total - own]
    smaller = np.minimum(sizes, n - sizes)
    return np.where(smaller < min_branch, -np.inf, gains / n), smaller


def best_of(gains: Floats, smaller: Integers) -> int | None:
    """Return the index of the largest gain; on a tie, that with the largest smaller side."""
    best = gains.max()
    if best == -np.inf:
        return None
    return int(np.argmax(np.where(gains >= best - TIE, smaller, -1)))
