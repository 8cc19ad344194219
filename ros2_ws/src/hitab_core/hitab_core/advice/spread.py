"""How much the values of a feature usually differ."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from hitab_core.arrays import Floats
from hitab_core.domain import FeatureKind, Scale


def spreads(values: Floats, scales: Sequence[Scale]) -> Floats:
    """Return the usual difference of two values of each feature: the median of all pairs.

    Equal ones are left out. It is a median since a domain may say 1000 m where there is nothing.

    Args:
        values: shape (n, m); NaN: missing.
        scales: how the values of each of the m features compare.

    Returns:
        shape (m,); 1 for features that compare by equality, and where all values are equal.
    """
    found = np.ones(len(scales))
    for f, scale in enumerate(scales):
        if not scale.kind.is_measured:
            continue
        apart = np.abs(values[:, f, None] - values[None, :, f])
        if scale.kind is FeatureKind.TOROIDAL:
            apart %= scale.period
            apart = np.minimum(apart, scale.period - apart)
        apart = apart[apart > 0]  # NaN is not
        if len(apart):
            found[f] = float(np.median(apart))
    return found
