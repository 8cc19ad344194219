"""A short evaluation of what a team performs, and the score that it gives."""

from __future__ import annotations

import contextlib
import math
import statistics
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

from hitab_msgs.srv import Control, Snapshot
from pydantic import Field

from hitab_client.errors import SwarmError
from hitab_client.interruptions import not_interrupted
from hitab_client.world_client import WorldClient
from hitab_core.library.yaml_models import Record

BEFORE = "before_bootstrap"
"""The snapshot of the world as it was, while a generation is evaluated."""

LENGTH = "seconds"
"""The figure that every world reports: how long an episode lasted, s."""


class Figure(Record):
    """A mean with its standard error; None: unknown, from a single episode."""

    mean: float
    error: float | None

    def __str__(self) -> str:
        shown = f"{self.mean:.2f}"
        return shown if self.error is None else f"{shown} ± {self.error:.2f}"


class Score(Record):
    """What a short evaluation has shown.

    Attributes:
        episodes: how many were played.
        seed: of the run.
        figures: what the world reports of each episode, by name; `LENGTH` always.
        ended: how often the episodes ended in which way.
        reproducible: whether the same seed gives the same figures again.
    """

    episodes: int = Field(ge=1)
    seed: int = Field(ge=0)
    figures: dict[str, Figure]
    ended: dict[str, Annotated[int, Field(ge=0)]]
    reproducible: bool


@dataclass(frozen=True)
class Evaluation:
    """So many episodes, none for no score, with this seed."""

    episodes: int = 20
    seed: int = 1


SHORT = Evaluation()


def evaluated(
    world: WorldClient,
    evaluation: Evaluation,
    say: Callable[[str], None],
    progress: Callable[[int], None],
) -> Score:
    """Play some episodes; then the world is as it was before, if it can be.

    Args:
        world: paused, in lockstep.
        evaluation: how many episodes, with which seed.
        say: called with what could not be done.
        progress: called with the number of episodes played.

    Raises:
        SwarmError: if the world stalls.
    """
    with _as_arranged(world, say):
        played = world.play(evaluation.episodes, evaluation.seed, progress=progress)
    return score_of(played, evaluation.seed)


@contextlib.contextmanager
def _as_arranged(world: WorldClient, say: Callable[[str], None]) -> Iterator[None]:
    """Bring the situation back that the demonstrator had arranged, if the world can."""
    try:
        world.snapshot(Snapshot.Request.SAVE, BEFORE)
    except SwarmError as error:
        say(f"a new episode follows the evaluation, since {error}")
        yield
        return
    try:
        yield
    except BaseException:
        with not_interrupted(), contextlib.suppress(SwarmError):  # the first error is reported
            world.play(0, world.wait().seed)  # without a limit, or it would stop after the rest
            _arrange_again(world)
        raise
    with not_interrupted():
        _arrange_again(world)


def _arrange_again(world: WorldClient) -> None:
    world.shown(world.control(Control.Request.PAUSE))
    world.shown(world.snapshot(Snapshot.Request.RESTORE, BEFORE))
    world.snapshot(Snapshot.Request.DELETE, BEFORE)


def score_of(played: Sequence[Any], seed: int) -> Score:
    """Return the score that the results of some episodes give."""
    values: dict[str, list[float]] = {LENGTH: [float(e.seconds) for e in played]}
    for episode in played:
        for name, value in zip(episode.measure_names, episode.measures, strict=True):
            values.setdefault(name, []).append(float(value))
    figures = {
        name: _figure([v for v in all_ if math.isfinite(v)]) for name, all_ in values.items()
    }
    return Score(
        episodes=len(played),
        seed=seed,
        figures={name: figure for name, figure in figures.items() if figure is not None},
        ended=dict(Counter(e.ended for e in played)),
        reproducible=all(e.reproducible for e in played),
    )


def _figure(values: Sequence[float]) -> Figure | None:
    if not values:
        return None
    if len(values) == 1:
        return Figure(mean=values[0], error=None)
    return Figure(
        mean=statistics.fmean(values), error=statistics.stdev(values) / math.sqrt(len(values))
    )
