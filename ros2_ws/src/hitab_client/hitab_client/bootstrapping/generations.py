"""The generations of behavior bootstrapping: versions of a behavior, with notes and scores.

The library of the trained agent has the versions. What else is known of them is in the run folder,
as ``generations/keeper_1/Keepaway.yaml``.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml
from pydantic import ConfigDict, Field

from hitab_client.errors import SwarmError
from hitab_core.library.durable_files import file_errors, write_durably
from hitab_core.library.yaml_models import Format, Record, Texts, open_record
from hitab_core.library.yaml_places import open_yaml

FORMAT = 2
"""The format version that is written, and the newest that is read; 1 says more, which is left."""

LENGTH = "seconds"
"""The figure that every world reports: how long an episode lasted, s."""


class _Record(Record):
    """A mapping of which only these keys count."""

    model_config = ConfigDict(extra="ignore")


class Figure(_Record):
    """A mean with its standard error; None: unknown, from a single episode."""

    mean: float
    error: float | None

    def __str__(self) -> str:
        shown = f"{self.mean:.2f}"
        return shown if self.error is None else f"{shown} ± {self.error:.2f}"


class Score(_Record):
    """What so many episodes with this seed have shown, by figure; no episodes: nothing."""

    episodes: int = 0
    seed: int = 0
    figures: dict[str, Figure] = Field(default_factory=dict)


class Generation(_Record):
    """One version of a behavior that was given to the team and evaluated.

    Attributes:
        version: of the behavior in the library of the trained agent.
        at: when it was made, ISO 8601.
        by: the demonstrator.
        examples: that it was learned from, default ones included.
        arguments: what its parameters were bound to.
        note: free text.
        score: of its evaluation.
        unscored: why there is no score, such as who of the team lacks it; empty if there is one.
    """

    version: int = Field(ge=1)
    at: str
    by: str
    examples: int
    arguments: Texts = ()
    note: str = ""
    score: Score = Score()
    unscored: str = ""


class Generations(_Record):
    """All generations of one behavior of one agent, by ascending version.

    Attributes:
        path: of their file.
    """

    path: Path = Field(default=Path(), alias=":path", exclude=True)
    format: Format = FORMAT
    all: tuple[Generation, ...] = Field(default=(), alias="generations", strict=False)

    def best(self, figure: str = LENGTH, *, least: bool = False) -> int:
        """Return the version with the best score; 0: there is none.

        Those are compared that were evaluated with as many episodes and the same seed as the one
        evaluated last.
        """
        scored = [g for g in self.all if figure in g.score.figures]
        means = {
            g.version: g.score.figures[figure].mean
            for g in reversed(scored)
            if (g.score.episodes, g.score.seed)
            == (scored[-1].score.episodes, scored[-1].score.seed)
        }
        return (min if least else max)(means, key=means.__getitem__, default=0)

    def keep(self, generation: Generation) -> None:
        """Write them with one more, or with a changed one.

        Raises:
            LibraryError: if they cannot be written.
        """
        others = [g for g in self.all if g.version != generation.version]
        content = self.but(format=FORMAT, all=(*others, generation))
        plain = content.model_dump(mode="json", by_alias=True)
        text = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True, width=100)
        with file_errors(self.path, "write"):
            write_durably(self.path, text.encode())


def folder_of(run_folder: Path, agent: str) -> Path:
    """Return the folder with a file for each behavior of an agent that has generations."""
    return run_folder / "generations" / agent


def read_generations(folder: Path, behavior: str) -> Generations:
    """Return the generations of a behavior; none if there is no file.

    Raises:
        SwarmError: naming all that is wrong with the file, by line.
    """
    path = folder / f"{behavior}.yaml"
    if not path.exists():
        return Generations().but(path=path)
    return open_record(Generations, open_yaml(path, error=SwarmError), FORMAT).but(path=path)


def score_of(played: Sequence[Any], seed: int) -> Score:
    """Return the score that the results of some episodes give."""
    values: dict[str, list[float]] = {}
    for episode in played:
        measured = zip(episode.measure_names, episode.measures, strict=True)
        for name, value in ((LENGTH, episode.seconds), *measured):
            if math.isfinite(value):
                values.setdefault(name, []).append(float(value))
    figures = {
        name: Figure(
            mean=statistics.fmean(all_),
            error=statistics.stdev(all_) / math.sqrt(len(all_)) if len(all_) > 1 else None,
        )
        for name, all_ in values.items()
    }
    return Score(episodes=len(played), seed=seed, figures=figures)
