"""How far a situation is from the nearest of some examples.

The distance to an example is the largest of the distances in the single features, so that it means
the same however many features matter. In one feature it is

- on a line: the difference, divided by the spread of the examples, which is the median difference
  of two of them that differ;
- on a circle: the shorter way round, divided by the median such way;
- for booleans and categories: 0 if equal, else 1.

So 0 is where an example is, and 1 as far from it as examples usually are from each other. A value
that is missing, in the situation or in an example, is left out; an example that has none of the
values is no neighbor.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from hitab_core.arrays import Floats
from hitab_core.domain import FeatureKind, Scale
from hitab_core.spread import spreads

UNKNOWN = math.inf
"""The distance where no example has any of the values."""


def apart(some: Floats, others: Floats, scales: Sequence[Scale], spread: Floats) -> Floats:
    """Return the distances of situations from others; where nothing compares, `UNKNOWN`.

    Args:
        some, others: shapes (k, m) and (n, m); toroidal values in [0, period); NaN: not known.
        scales: how the values of each of the m features compare.
        spread: shape (m,), the usual differences, see `spreads`.

    Returns:
        shape (k, n).
    """
    away = np.abs(some[:, None, :] - others[None, :, :])
    for f, scale in enumerate(scales):
        if scale.kind is FeatureKind.TOROIDAL:
            away[:, :, f] = np.minimum(away[:, :, f], scale.period - away[:, :, f])
        if not scale.kind.is_measured:
            away[:, :, f] = np.where(np.isnan(away[:, :, f]), np.nan, away[:, :, f] > 0)
    away /= spread
    known = ~np.isnan(away).all(axis=2)
    return np.where(known, np.fmax.reduce(away, axis=2, initial=0.0), UNKNOWN)


class Nearness:
    """Measures the distance from the nearest of some examples, in some of their features."""

    __slots__ = ("_circles", "_columns", "_features", "_largest", "_lengths", "_spreads")

    def __init__(self, values: Floats, scales: Sequence[Scale], features: Sequence[int]) -> None:
        """Prepare to measure; the time for one distance hardly depends on the features.

        Args:
            values: shape (n, m), of the examples; toroidal ones in [0, period); NaN: not known.
            scales: how the values of each of the m features compare.
            features: indices of those that matter.
        """
        self._features = tuple(features)
        own = [scales[f] for f in self._features]
        rows = values[:, self._features]
        self._spreads = spreads(rows, own)
        rows = np.unique(rows, axis=0, equal_nan=True)
        rows = rows[~np.isnan(rows).all(axis=1)] / self._spreads
        self._columns = np.ascontiguousarray(rows.T)
        # Where there is no circle its length is 0 or infinite, which changes nothing below.
        self._circles = [s.period if s.kind is FeatureKind.TOROIDAL else 0.0 for s in own]
        lengths = np.array([circle or math.inf for circle in self._circles])
        self._lengths = (lengths / self._spreads).reshape(-1, 1)
        largest = [math.inf if s.kind.is_measured else 1.0 for s in own]
        self._largest = np.array(largest).reshape(-1, 1)

    def __call__(self, values: Sequence[float | None]) -> float:
        """Return the distance of a situation; `UNKNOWN` if no example is comparable.

        Args:
            values: of all m features; None or NaN: not known.
        """
        if not self._features:
            return 0.0
        place = [
            math.nan if (value := values[f]) is None else value % circle if circle else value
            for f, circle in zip(self._features, self._circles, strict=True)
        ]
        away = np.abs(self._columns - (np.array(place) / self._spreads)[:, None])
        away = np.minimum(np.minimum(away, self._lengths - away), self._largest)
        return float(np.fmin.reduce(np.fmax.reduce(away), initial=UNKNOWN))
