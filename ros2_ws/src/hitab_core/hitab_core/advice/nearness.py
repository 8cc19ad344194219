"""Distance of a situation from the nearest of some examples.

The distance to an example is the largest of the distances in the single features, and so means
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

from hitab_core.domain import Scale
from hitab_core.numeric.arrays import Floats
from hitab_core.numeric.spread import differences, spreads

UNKNOWN_DISTANCE = math.inf
"""The distance where no example has any of the values."""


def apart(some: Floats, others: Floats, scales: Sequence[Scale], spread: Floats) -> Floats:
    """Return the distances of situations from others; where nothing compares, `UNKNOWN_DISTANCE`.

    Args:
        some, others: shapes (k, m) and (n, m); NaN if unknown.
        scales: scale of each of the m features.
        spread: shape (m,), the usual differences, see `spreads`.

    Returns:
        shape (k, n).
    """
    away = np.empty((len(scales), len(some), len(others)))
    for f, scale in enumerate(scales):
        away[f] = differences(some[:, f], others[:, f], scale) / spread[f]
    known = ~np.isnan(away).all(axis=0)
    return np.where(known, np.fmax.reduce(away, axis=0, initial=0.0), UNKNOWN_DISTANCE)


class Nearness:
    """Measures the distance from the nearest of some examples, in some of their features."""

    __slots__ = ("_features", "_scales", "_spread", "_values")

    def __init__(self, values: Floats, scales: Sequence[Scale], features: Sequence[int]) -> None:
        """Prepare to measure.

        Args:
            values: shape (n, m), of the examples; NaN if unknown.
            scales: scale of each of the m features.
            features: indices of the relevant features.
        """
        self._features = list(features)
        self._scales = [scales[f] for f in self._features]
        self._values = values[:, self._features]
        self._spread = spreads(self._values, self._scales)

    def __call__(self, values: Sequence[float | None]) -> float:
        """Return the distance of a situation; `UNKNOWN_DISTANCE` if no example is comparable.

        Args:
            values: values of all m features; None or NaN if unknown.
        """
        if not self._features:
            return 0.0
        place = np.array([[values[f] for f in self._features]], np.float64)
        away = apart(place, self._values, self._scales, self._spread)
        return float(away.min(initial=UNKNOWN_DISTANCE))
