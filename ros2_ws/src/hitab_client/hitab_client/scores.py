"""Scores of played episodes, by measure."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_msgs.msg import Episode
from pydantic import ConfigDict, Field

from hitab_client.measures import estimate, values_of
from hitab_core import quantity
from hitab_core.library.yaml_models import Record


class Figure(Record):
    """A mean with its standard error, which is None (unknown) for a single episode."""

    mean: float
    error: float | None

    def __str__(self) -> str:
        return f"{self.mean:.2f}" + ("" if self.error is None else f" ± {self.error:.2f}")


class Score(Record):
    """Means of a number of episodes with one seed, by measure; empty without episodes."""

    model_config = ConfigDict(extra="ignore")  # earlier formats have more fields
    episodes: int = 0
    seed: int = 0
    figures: dict[str, Figure] = Field(default_factory=dict)

    def __str__(self) -> str:
        figures = [f"{figure} {name}" for name, figure in self.figures.items()]
        return f"{', '.join(figures)}; {self.played}" if figures else "no score"

    @property
    def played(self) -> str:
        """Text with the number of episodes and the seed; empty without an evaluation."""
        return f"{quantity(self.episodes, 'episode')}, seed {self.seed}" if self.episodes else ""


def score_of(played: Sequence[Episode], seed: int) -> Score:
    """Return the score of episodes with this seed."""
    figures = {
        name: Figure(mean=found.mean, error=found.se)
        for name, values in values_of(played).items()
        if (found := estimate(values)).mean is not None
    }
    return Score(episodes=len(played), seed=seed, figures=figures)
