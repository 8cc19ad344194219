"""Scores: what played episodes have shown, by measure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import fmean, stdev

from hitab_msgs.msg import Episode
from pydantic import ConfigDict, Field

from hitab_core import quantity
from hitab_core.library.yaml_models import Record

LENGTH = "seconds"
"""The measure that every world reports: how long an episode lasted, s."""


class Figure(Record):
    """A mean with its standard error; None: unknown, from a single episode."""

    mean: float
    error: float | None

    def __str__(self) -> str:
        return f"{self.mean:.2f}" + ("" if self.error is None else f" ± {self.error:.2f}")


class Score(Record):
    """What so many episodes with this seed have shown, by measure; no episodes: nothing."""

    model_config = ConfigDict(extra="ignore")  # earlier formats say more
    episodes: int = 0
    seed: int = 0
    figures: dict[str, Figure] = Field(default_factory=dict)

    def __str__(self) -> str:
        figures = [f"{figure} {name}" for name, figure in self.figures.items()]
        return f"{', '.join(figures)}; {self.played}" if figures else "no score"

    @property
    def played(self) -> str:
        """What it was evaluated with; empty if it was not."""
        return f"{quantity(self.episodes, 'episode')}, seed {self.seed}" if self.episodes else ""


def values_of(played: Sequence[Episode]) -> dict[str, list[float]]:
    """Return the values of each measure in episodes: first their length, then the world's own.

    A value that is not finite is left out.
    """
    found: dict[str, list[float]] = {LENGTH: []}
    for one in played:
        measured = zip(one.measure_names, one.measures, strict=True)
        for name, value in ((LENGTH, one.seconds), *measured):
            if math.isfinite(value):
                found.setdefault(name, []).append(float(value))
    return found


def score_of(played: Sequence[Episode], seed: int) -> Score:
    """Return the score that episodes with this seed give."""
    figures = {
        name: Figure(
            mean=fmean(values),
            error=stdev(values) / math.sqrt(len(values)) if len(values) > 1 else None,
        )
        for name, values in values_of(played).items()
    }
    return Score(episodes=len(played), seed=seed, figures=figures)
