"""Regression by the nearest moments shown: numbers as in the moments most like the situation.

The numbers are the mean over the three nearest moments, weighted by the inverse of their
distance, as scikit-learn's ``KNeighborsRegressor(3, weights="distance")`` has it; on a circle, the
mean direction. So they never leave the range of the moments shown, however far the situation is,
are exact at a moment shown, and are explained by three moments. Learning is sorting them into
arrays, which an agent does while it runs.

A situation is a point: a feature is a line in units of its usual difference, see
`hitab_core.numeric.spread`, a circle on which a short way has this length, or, with categories,
corners that are 1 apart. The distance is Euclidean; a missing value counts as 1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from hitab_core.domain import Scale
from hitab_core.example import Example
from hitab_core.number import BoundedNumber
from hitab_core.numeric.arrays import Floats
from hitab_core.numeric.spread import spreads
from hitab_core.term import Term

NEAREST = 3
MOMENTS_MAX = 1000
"""Maximum number of moments; more are thinned out to those farthest from one another."""

SPREAD_ROWS = 300
"""Usual differences are taken from this many moments, since they need all pairs."""

OPPOSED = 1e-6
"""Directions whose mean vector is shorter than this have no mean."""


class NumberExample(NamedTuple):
    """One of the moments that numbers were taken from.

    Attributes:
        example: number of the example.
        distance: distance from the situation, in usual differences.
        weight: share in the numbers, from 0 to 1.
    """

    example: int
    distance: float
    weight: float


class NumberTable(NamedTuple):
    """Learned numbers as plain data, for other programs.

    Attributes:
        axes: by feature, the turn and the radius of its circle, both 0 if it has none, its usual
            difference and its number of categories.
        moments: the place of each and its numbers.
    """

    axes: tuple[tuple[float, float, float, int], ...] = ()
    moments: tuple[tuple[tuple[float, ...], tuple[float, ...]], ...] = ()


class Neighbors:
    """Numbers of a behavior as a function of features; a `hitab_core` ``NumberFunction``.

    Examples:
        >>> shown = Neighbors([[0.0], [1.0]], [[170.0], [-170.0]], [Scale()],
        ...                   [BoundedNumber("direction", -180, 180, circular=True)])
        >>> shown([0.5]), shown([0.0])
        ((-180.0,), (170.0,))
    """

    def __init__(
        self,
        values: Sequence[Sequence[float]] | Floats,
        numbers: Sequence[Sequence[float]] | Floats,
        scales: Sequence[Scale],
        wanted: Sequence[BoundedNumber],
        examples: Sequence[int] = (),
    ) -> None:
        """Learn from moments.

        Args:
            values: shape (n, m), of the features at each moment; NaN where one had no value.
            numbers: shape (n, k), the numbers shown there, within the bounds.
            scales: scale of each of the m features.
            wanted: the k numbers.
            examples: the number of each moment; empty to count from 0.
        """
        rows = np.array(values, dtype=np.float64).reshape(len(values), len(scales))
        step = -(-len(rows) // SPREAD_ROWS)
        self._axes = _axes(scales, spreads(rows[::step], scales).tolist())
        places = np.array([self._place(row) for row in rows.tolist()]).reshape(len(rows), -1)
        kept = _apart(places) if len(rows) > MOMENTS_MAX else list(range(len(rows)))
        self._places = np.ascontiguousarray(places[kept].T)
        self._complete = not np.isnan(places).any()
        self._examples = [examples[i] if examples else i for i in kept]
        found = np.array(numbers, dtype=np.float64).reshape(len(rows), -1)
        self._numbers = found[kept].tolist()
        self._wanted = tuple(wanted)

    @property
    def table(self) -> NumberTable:
        """Learned numbers, as plain data."""
        places = map(tuple, self._places.T.tolist())
        moments = tuple(zip(places, map(tuple, self._numbers), strict=True))
        return NumberTable(tuple(axis.form for axis in self._axes), moments)

    def _place(self, values: Sequence[float]) -> list[float]:
        """Return a situation as a point."""
        return [x for axis, value in zip(self._axes, values, strict=True) for x in axis(value)]

    def _squared(self, values: Sequence[float]) -> Floats | None:
        """Return the squared distance of each moment; None if there is no value."""
        lacking = sum(value != value for value in values)
        if lacking and lacking == len(values):
            return None
        away = self._places - np.array(self._place(values))[:, None]
        if lacking or not self._complete:
            for axis in self._axes:
                own = away[axis.columns]
                own[np.isnan(own)] = len(own) ** -0.5
        squared: Floats = np.einsum("ij,ij->j", away, away)
        return squared

    def _nearest(self, values: Sequence[float]) -> list[NumberExample]:
        """Return the nearest moments, by their index among those kept."""
        squared = self._squared(values)
        if squared is None:
            return []
        count = min(NEAREST, len(squared))
        rows = squared.argpartition(count - 1)[:count]
        found = sorted(zip(np.sqrt(squared[rows]).tolist(), rows.tolist(), strict=True))
        least = found[0][0]
        shares = [least / d if least else float(not d) for d, _ in found]
        total = sum(shares)
        return [
            NumberExample(row, distance, share / total)
            for (distance, row), share in zip(found, shares, strict=True)
        ]

    def nearest(self, values: Sequence[float]) -> list[NumberExample]:
        """Return the moments that the numbers are taken from here, the nearest first.

        Args:
            values: values of the m features; NaN where one has no value. Without any value
                there are no moments.
        """
        return [m._replace(example=self._examples[m.example]) for m in self._nearest(values)]

    def distance(self, values: Sequence[float]) -> float:
        """Return how far a situation is from the nearest moment; infinite if none compares."""
        squared = self._squared(values)
        return math.inf if squared is None else math.sqrt(squared.min())

    def __call__(self, values: Sequence[float]) -> tuple[float, ...]:
        """Return the numbers for a situation; nothing if it has no values."""
        moments = self._nearest(values)
        if not moments:
            return ()
        shown = [self._numbers[m.example] for m in moments]
        weights = [m.weight for m in moments]
        return tuple(
            mean([row[k] for row in shown], weights, number)
            for k, number in enumerate(self._wanted)
        )


def mean(values: Sequence[float], weights: Sequence[float], number: BoundedNumber) -> float:
    """Return the weighted mean of values of a number; the first if directions are opposed.

    Args:
        values: within its bounds.
        weights: weights of the values, with the sum 1.
        number: the number that has these values.
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


class _Axis:
    """One feature in the space of situations: a line, a circle in a plane, or one-hot."""

    def __init__(self, scale: Scale, usual: float, first: int) -> None:
        self._scale, self._usual = scale, usual
        self._turn = 2.0 * math.pi / scale.period if scale.period else 0.0
        size = 2 if self._turn else max(1, len(scale.categories))
        self.columns = slice(first, first + size)
        self._radius = 1.0 / (self._turn * usual) if self._turn else 0.0

    @property
    def form(self) -> tuple[float, float, float, int]:
        """The turn, radius, usual difference and number of categories of the feature."""
        return self._turn, self._radius, self._usual, len(self._scale.categories)

    def __call__(self, value: float) -> Sequence[float]:
        """Return the coordinates of a value; NaN if it is missing."""
        if self._turn:
            angle = value * self._turn
            return self._radius * math.cos(angle), self._radius * math.sin(angle)
        if self._scale.categories:
            known = value == value
            return [
                math.sqrt(0.5) * (value == i) if known else value
                for i in range(len(self._scale.categories))
            ]
        return (value / self._usual,)


def _axes(scales: Sequence[Scale], usual: Sequence[float]) -> list[_Axis]:
    axes: list[_Axis] = []
    for scale, difference in zip(scales, usual, strict=True):
        axes.append(_Axis(scale, difference, axes[-1].columns.stop if axes else 0))
    return axes


def _apart(places: Floats) -> list[int]:
    """Return the moments that are farthest from those chosen before, from the first one on."""
    places = np.nan_to_num(places)
    chosen = [0]
    nearest = np.full(len(places), math.inf)
    while len(chosen) < MOMENTS_MAX:
        away = places - places[chosen[-1]]
        np.minimum(nearest, np.einsum("ij,ij->i", away, away), out=nearest)
        chosen.append(int(nearest.argmax()))
    return sorted(chosen)


def learn_numbers(
    states: Iterable[Term],
    scales: Sequence[Scale],
    examples: Iterable[Example],
    numbers_of: Callable[[Term], Sequence[BoundedNumber]],
) -> dict[str, Neighbors]:
    """Return the functions for the numbers of states that take numbers, by label.

    A state learns from all commands of it, whatever state they left. Without one that gave
    numbers, nothing is learned for it.

    Args:
        states: states of the automaton.
        scales: scale of each feature.
        examples: examples with one value per feature.
        numbers_of: returns the numbers that the behavior of a state takes.
    """
    learned = {}
    shown = [example for example in examples if example.numbers]
    for state in states:
        if wanted := numbers_of(state):
            own = [example for example in shown if example.next_state == str(state)]
            if own:
                values = [example.features for example in own]
                numbers = [example.numbers for example in own]
                learned[str(state)] = Neighbors(
                    values, numbers, scales, wanted, [e.number for e in own]
                )
    return learned
