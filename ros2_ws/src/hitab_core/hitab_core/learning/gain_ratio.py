"""Information gain and gain ratio, from the number of examples of each class per branch.

Where values are missing, examples count in fractions: all functions take whole numbers or floats.

Reference: J. R. Quinlan, C4.5: Programs for Machine Learning, Morgan Kaufmann 1993, chapters 2
and 3.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from hitab_core.numeric.arrays import Floats, Integers

Counts = Integers | Floats
"""Numbers of examples; floats where some count only in part."""

TIE = 1e-9
"""Gains (in bits) and gain ratios that differ by less than this count as equal."""


def _n_log_n(largest: Any) -> Callable[[Any], Any]:
    """Return the function ``n log2 n`` for numbers up to ``largest``; if whole, from a table."""
    if isinstance(largest, np.floating):
        return _n_log_n_of_fractions
    table = np.arange(largest + 1, dtype=np.float64)
    table[1:] *= np.log2(table[1:])
    return table.__getitem__


def _n_log_n_of_fractions(n: Any) -> Any:
    # Differences of equal sums may be a little below zero.
    return n * np.log2(n, out=np.zeros_like(n), where=n > 0)


def gain_and_ratio(counts: Counts, unknown: float = 0) -> tuple[float, float]:
    """Return information gain (bits) and gain ratio of a split.

    The gain of the examples with a value is multiplied by the fraction that has one; in the
    split information the examples without a value are one more branch.

    Args:
        counts: shape (n_branches, n_classes), examples of each class in each branch.
        unknown: number of examples without a value.
    """
    if unknown:
        counts = counts.astype(np.float64)
    sizes = counts.sum(axis=1)
    n = sizes.sum()
    everybody = n + unknown if unknown else n
    n_log_n = _n_log_n(everybody)
    before = n_log_n(n) - n_log_n(counts.sum(axis=0)).sum()
    after = n_log_n(sizes).sum() - n_log_n(counts).sum()
    split_information = n_log_n(everybody) - n_log_n(sizes).sum()
    if unknown:
        split_information -= n_log_n(np.float64(unknown))
    gain = max(0.0, float(before - after) / float(everybody))
    return gain, gain * float(everybody) / float(
        split_information
    ) if split_information > 0 else 0.0


def two_way_gains(inside: Counts, totals: Counts, min_branch: float) -> tuple[Floats, Counts]:
    """Return each two-way split's gain, up to a constant, and the size of its smaller side.

    Args:
        inside: shape (n_classes, ...), examples of each class in each split's first branch.
        totals: shape (n_classes,), the examples of each class in the node.
        min_branch: the fewest examples a branch may have; with fewer the gain is -inf.
    """
    n = totals.sum()
    n_log_n = _n_log_n(n)
    sizes = inside.sum(axis=0)
    gains = -n_log_n(sizes) - n_log_n(n - sizes)
    for own, total in zip(inside, totals, strict=True):
        gains += n_log_n(own) + n_log_n(total - own)
    smaller = np.minimum(sizes, n - sizes)
    return np.where(smaller < min_branch, -np.inf, gains / n), smaller


def best_of(gains: Floats, smaller: Counts) -> int | None:
    """Return the index of the largest gain; on a tie, that with the largest smaller side."""
    best = gains.max()
    if best == -np.inf:
        return None
    return int(np.argmax(np.where(gains >= best - TIE, smaller, -1)))
