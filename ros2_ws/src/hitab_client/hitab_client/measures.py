"""Measures of episodes: values by name, and estimates of their means."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist, fmean, stdev
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hitab_msgs.msg import Episode

SECONDS = "seconds"
"""Name of the measure that all episodes have."""

CERTAIN = 0.95
"""Confidence level of the intervals."""


@dataclass(frozen=True)
class Estimate:
    """The mean of a measure over episodes.

    Attributes:
        mean: mean of all values; None without values.
        se: standard error of the mean; None for fewer than two values.
        low, high: 95 % confidence interval of the mean, from Student's t distribution; None
            for fewer than two values.
    """

    mean: float | None
    se: float | None = None
    low: float | None = None
    high: float | None = None

    def rounded(self) -> dict[str, float]:
        """Return mean and standard error as plain data, with 0 for an unknown one."""
        return {"mean": round(self.mean or 0.0, 4), "se": round(self.se or 0.0, 4)}


def values_of(played: Sequence[Episode]) -> dict[str, list[float]]:
    """Return the values of all measures of episodes by name, the length of the episodes first."""
    values = {SECONDS: [float(one.seconds) for one in played]}
    for one in played:
        for measure in one.measures:
            values.setdefault(measure.name, []).append(float(measure.value))
    return values


def estimate(values: Sequence[float]) -> Estimate:
    """Return the estimate of a mean; values that are not finite are left out."""
    known = [value for value in values if math.isfinite(value)]
    if len(known) < 2:
        return Estimate(known[0] if known else None)
    mean, error = fmean(known), stdev(known) / math.sqrt(len(known))
    within = student_t(len(known) - 1) * error
    return Estimate(mean, error, mean - within, mean + within)


def student_t(freedom: int) -> float:
    """Return the half-width of the 95 % interval, in standard errors.

    Exact for one and two degrees of freedom; for more, to a thousandth (Abramowitz and Stegun,
    26.7.5).
    """
    p = (1.0 + CERTAIN) / 2.0
    if freedom == 1:
        return math.tan(math.pi * (p - 0.5))
    if freedom == 2:
        return (2.0 * p - 1.0) / math.sqrt(2.0 * p * (1.0 - p))
    z = NormalDist().inv_cdf(p)
    terms = (
        z,
        (z**3 + z) / 4,
        (5 * z**5 + 16 * z**3 + 3 * z) / 96,
        (3 * z**7 + 19 * z**5 + 17 * z**3 - 15 * z) / 384,
        (79 * z**9 + 776 * z**7 + 1482 * z**5 - 1920 * z**3 - 945 * z) / 92160,
    )
    return sum(term / freedom**power for power, term in enumerate(terms))
