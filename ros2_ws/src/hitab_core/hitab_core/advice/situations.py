"""Situations in which to ask which of two explanations holds.

Preferred are readings that were perceived in this training: first those in the state itself, then
those in other states. Only if these are too few to say what occurs is a situation composed: an
example of the state, with one value exchanged for another one that was seen. By the rule of three,
what occurred in none of n readings occurs in less than 3/n of them, with 95% confidence. So if
there are more than `ENOUGH` readings, and the explanations differ in none of them, they hardly
ever will, and nothing is composed. A composed situation may still be one that cannot come about;
a person who sees it can dismiss the question.

Reference: J. A. Hanley, A. Lippman-Hand, If Nothing Goes Wrong, Is Everything All Right?, Journal
of the American Medical Association 249, 1983.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.advice.evidence import Evidence, on_circles
from hitab_core.arrays import Booleans, Floats

ENOUGH = 30
"""Readings from which it follows that what is not among them occurs in less than a tenth."""


class Origin(IntEnum):
    """Where a situation comes from, the most plausible first."""

    HERE = 0  # perceived while the state was active
    ELSEWHERE = 1  # perceived in this training
    COMPOSED = 2  # of values that were perceived


@dataclass(frozen=True, eq=False)
class Perceived:
    """What was perceived in a training, in the order of the automaton's features.

    Attributes:
        values: shape (k, m), each distinct reading once; NaN: not known.
        here: shape (k,), whether it was perceived while the state in question was active.
        times: shape (k,), how often it was perceived.
    """

    values: Floats
    here: Booleans
    times: Floats = field(repr=False)

    @classmethod
    def of(cls, evidence: Evidence, readings: ArrayLike, here: ArrayLike | None) -> Perceived:
        """Return the distinct readings, and the values of the state's examples among them.

        Args:
            evidence: the examples of the state.
            readings: shape (k, m).
            here: shape (k,); None: not known of any.

        Raises:
            ValueError: if the shapes do not match.
        """
        m = len(evidence.scales)
        given = np.asarray(readings, np.float64)
        given = given.reshape(len(given), m) if given.size == 0 else given
        where = np.zeros(len(given), np.bool_) if here is None else np.asarray(here, np.bool_)
        if given.ndim != 2 or given.shape[1] != m or where.shape != (len(given),):
            raise ValueError(
                f"expected readings of shape (k, {m}) and k flags, "
                f"got {given.shape} and {where.shape}"
            )
        own = evidence.values
        values = np.vstack([own, on_circles(given, evidence.scales)])
        there = np.append(np.ones(len(own), np.bool_), where)
        # NaN is replaced since it does not equal itself; no value is infinite.
        keys = np.column_stack([np.nan_to_num(values, nan=np.inf), there])
        _, first, times = np.unique(keys, axis=0, return_index=True, return_counts=True)
        order = np.argsort(first)
        kept = first[order]
        return cls(values[kept], there[kept], times[order].astype(np.float64))

    @property
    def enough(self) -> bool:
        """Whether what is not among them hardly ever occurs."""
        return float(self.times.sum()) > ENOUGH


def composed(
    evidence: Evidence, perceived: Perceived, features: Sequence[int]
) -> Iterator[tuple[float, ...]]:
    """Yield examples of the state with one value exchanged for another one that was seen.

    All values that do not matter are NaN.

    Args:
        evidence: the examples of the state.
        perceived: where other values are taken from.
        features: those that matter.
    """
    matter = list(features)
    blank = np.full(len(evidence.scales), np.nan)
    seen: set[tuple[float, ...]] = set()
    for row in evidence.values:
        for f in matter:
            for value in np.unique(perceived.values[:, f]).tolist():
                made = blank.copy()
                made[matter] = row[matter]
                made[f] = value
                key = tuple(made[matter].tolist())
                if key not in seen and value != row[f] and not np.isnan(made[matter]).any():
                    seen.add(key)
                    yield tuple(made.tolist())
