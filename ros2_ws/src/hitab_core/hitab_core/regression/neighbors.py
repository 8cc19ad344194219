"""Regression by the nearest moments shown: numbers as in those that are most like the situation.

The numbers are a mean of those of the three nearest moments, weighted by the inverse of their
distance, as scikit-learn's ``KNeighborsRegressor(3, weights="distance")`` has it; on a circle, the
mean direction. So they never leave what was shown, however far the situation is from it, a moment
shown is answered exactly, and an answer is explained by three moments. Learning is sorting them
into arrays, which an agent does while it runs.

Two situations differ in a feature as in `hitab_core.advice.nearness`, by its usual difference; the
distance is Euclidean. A value that one of them lacks counts as one usual difference.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from hitab_core.arrays import Floats
from hitab_core.domain import FeatureKind, Scale
from hitab_core.number import Number
from hitab_core.spread import spreads

NEAREST = 3
MOMENTS_MAX = 1000
"""More moments than this are thinned out to those that are farthest from one another."""

SPREAD_ROWS = 1000
"""Usual differences are taken from so many moments, since they need all pairs."""

OPPOSED = 1e-6
"""Directions whose mean vector is shorter than this have no mean."""


class Moment(NamedTuple):
    """One of the moments that numbers were taken from.

    Attributes:
        row: its index among the moments shown.
        distance: from the situation, in usual differences.
        weight: its share in the numbers, from 0 to 1.
    """

    row: int
    distance: float
    weight: float


class Neighbors:
    """Numbers of a behavior as a function of features; a `hitab_core` ``NumberFunction``.

    Examples:
        >>> shown = Neighbors([[0.0], [1.0]], [[170.0], [-170.0]], [Scale()],
        ...                   [Number("direction", -180, 180, circular=True)])
        >>> shown([0.5]), shown([0.0])
        ((-180.0,), (170.0,))
    """

    def __init__(
        self,
        values: Sequence[Sequence[float]] | Floats,
        numbers: Sequence[Sequence[float]] | Floats,
        scales: Sequence[Scale],
        wanted: Sequence[Number],
    ) -> None:
        """Learn from moments.

        Args:
            values: shape (n, m), of the features at each moment; NaN where one had no value.
            numbers: shape (n, k), what was shown there, within the bounds.
            scales: how the values of each of the m features compare.
            wanted: the k numbers.
        """
        rows = np.array(values, dtype=np.float64).reshape(len(values), len(scales))
        measured = [s.kind.is_measured for s in scales]
        circles = [s.period if s.kind is FeatureKind.TOROIDAL else math.inf for s in scales]
        step = -(-len(rows) // SPREAD_ROWS)
        self._usual = spreads(rows[::step], scales)
        self._most = np.where(measured, math.inf, 1.0)[:, None]
        self._round = (np.array(circles) / self._usual)[:, None]
        self._wraps = bool(np.isfinite(self._round).any())
        self._places = np.ascontiguousarray((rows / self._usual).T)
        if self._wraps:
            turns = np.isfinite(self._round[:, 0])
            self._places[turns] %= self._round[turns]
        self._kept = np.arange(len(rows))
        if len(rows) > MOMENTS_MAX:
            self._thin_out()
        self._numbers = np.array(numbers, dtype=np.float64).reshape(len(rows), -1)[self._kept]
        self._wanted = tuple(wanted)

    def _thin_out(self) -> None:
        """Keep the moments that are farthest from those kept before, beginning with the first."""
        kept = [0]
        nearest = self._away(self._places[:, 0])
        for _ in range(MOMENTS_MAX - 1):
            kept.append(int(nearest.argmax()))
            np.minimum(nearest, self._away(self._places[:, kept[-1]]), out=nearest)
        self._kept = np.unique(kept)
        self._places = np.ascontiguousarray(self._places[:, self._kept])

    def _away(self, place: Floats) -> Floats:
        """Return the squared distance of each moment from a place, in usual differences."""
        away = np.abs(self._places - place[:, None])
        if self._wraps:
            np.minimum(away, self._round - away, out=away)
        np.minimum(away, self._most, out=away)
        away[np.isnan(away)] = 1.0
        squared: Floats = np.einsum("ij,ij->j", away, away)
        return squared

    def _place(self, values: Sequence[float]) -> Floats:
        place = np.asarray(values, dtype=np.float64) / self._usual
        if self._wraps:
            np.mod(place, self._round[:, 0], out=place, where=np.isfinite(self._round[:, 0]))
        return place

    def nearest(self, values: Sequence[float]) -> list[Moment]:
        """Return the moments that the numbers are taken from here, the nearest first.

        Args:
            values: of the m features; NaN where one has no value. None has one: no moments.
        """
        place = self._place(values)
        if len(place) and np.isnan(place).all():
            return []
        squared = self._away(place)
        count = min(NEAREST, len(squared))
        rows = squared.argpartition(count - 1)[:count]
        found = sorted((math.sqrt(squared[row]), int(row)) for row in rows)
        least = found[0][0]
        shares = [least / d if least else float(not d) for d, _ in found]
        total = sum(shares)
        return [
            Moment(int(self._kept[row]), distance, share / total)
            for (distance, row), share in zip(found, shares, strict=True)
        ]

    def distance(self, values: Sequence[float]) -> float:
        """Return how far a situation is from the nearest moment; infinite if none compares."""
        place = self._place(values)
        if len(place) and np.isnan(place).all():
            return math.inf
        return math.sqrt(self._away(place).min())

    def __call__(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the numbers for a situation; nothing if it has no values."""
        moments = self.nearest(values)
        if not moments:
            return ()
        at = np.searchsorted(self._kept, [m.row for m in moments])
        shown = self._numbers[at].tolist()
        weights = [m.weight for m in moments]
        return tuple(
            mean([row[k] for row in shown], weights, number)
            for k, number in enumerate(self._wanted)
        )


def mean(values: Sequence[float], weights: Sequence[float], number: Number) -> float:
    """Return the weighted mean of values of a number; the first if directions are opposed.

    Args:
        values: within its bounds.
        weights: theirs, with the sum 1.
        number: what they are values of.
    """
    if not number.circular:
        found = sum(v * w for v, w in zip(values, weights, strict=True))
        return min(max(found, number.low), number.high)
    turn = 2.0 * math.pi / (number.high - number.low)
    x = sum(w * math.cos(v * turn) for v, w in zip(values, weights, strict=True))
    y = sum(w * math.sin(v * turn) for v, w in zip(values, weights, strict=True))
    if math.hypot(x, y) < OPPOSED:
        return values[0]
    angle = math.atan2(y, x) / turn
    return number.low + (angle - number.low) % (number.high - number.low)
