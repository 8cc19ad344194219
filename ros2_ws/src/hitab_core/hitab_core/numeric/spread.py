"""Usual differences of feature values, and distances of situations in these units."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hitab_core.domain import FeatureKind, Scale
from hitab_core.numeric.arrays import Floats


def spreads(values: Floats, scales: Sequence[Scale]) -> Floats:
    """Return the usual difference of two values of each feature: the median of all pairs.

    Equal ones are left out. It is a median since a domain may say 1000 m where there is nothing.

    Args:
        values: shape (n, m); NaN if missing.
        scales: scale of each of the m features.

    Returns:
        shape (m,); 1 for features that compare by equality, and where all values are equal.
    """
    found = np.ones(len(scales))
    for f, scale in enumerate(scales):
        if not scale.kind.is_measured:
            continue
        apart = differences(values[:, f], values[:, f], scale)
        apart = apart[apart > 0]  # NaN is not
        if len(apart):
            found[f] = float(np.median(apart))
    return found


def differences(some: Floats, others: Floats, scale: Scale) -> Floats:
    """Return how much values of a feature differ from others, shape (k, n); NaN if one is missing.

    On a circle it is the shorter way round. Values that compare by equality differ by 0 or 1.

    Args:
        some, others: shapes (k,) and (n,).
        scale: scale of the feature.
    """
    apart = np.abs(some[:, None] - others)
    if scale.kind is FeatureKind.TOROIDAL:
        apart %= scale.period
        return np.minimum(apart, scale.period - apart)
    return apart if scale.kind.is_measured else np.sign(apart)
