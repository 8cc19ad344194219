"""Evaluates agents by the same episodes: measures, their means and comparisons."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import NormalDist, fmean, stdev
from typing import Any, NamedTuple

from hitab_world.inprocess import Between, Player, play
from hitab_world.world import MORE, SECONDS, EpisodeResult, Measure, World


class GameSetup(NamedTuple):
    """A world in this process, and what plays its agents.

    Attributes:
        between: called between the percepts and the actions of a cycle, such as for commanders.
    """

    world: World
    players: Mapping[str, Player]
    between: Between | None = None


CERTAIN = 0.95
"""How often an interval has the true mean in it."""


@dataclass(frozen=True)
class Estimate:
    """The mean of a measure over episodes.

    Attributes:
        mean: of all values; None if there are none.
        se: standard error of the mean; None for fewer than two values, as the others.
        low, high: the 95 % confidence interval of the mean, from Student's t distribution.
    """

    mean: float | None
    se: float | None = None
    low: float | None = None
    high: float | None = None


def estimate(values: Sequence[float]) -> Estimate:
    """Return the mean of values, of which those that are not finite do not count."""
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


def mean_and_error(values: Sequence[float]) -> dict[str, float]:
    """Return the mean and its standard error, rounded; 0 for what is not known."""
    found = estimate(values)
    return {"mean": round(found.mean or 0.0, 4), "se": round(found.se or 0.0, 4)}


def measures_of(world: World, results: Sequence[EpisodeResult]) -> Sequence[Measure]:
    """Return a world's declared measures, or else those of its results, as if more is better."""
    names = {name for result in results for name in result.measures}
    undeclared = (Measure(SECONDS, "s"), *map(Measure, sorted(names)))
    return getattr(world, "measures", ()) or undeclared


def play_alike(
    games: Sequence[GameSetup], episodes: int, *, longest: float = 0.0
) -> Iterator[tuple[EpisodeResult, ...]]:
    """Play the same episodes in each game; yield the results of each episode, in order of games.

    Args:
        games: with worlds of the same seed and figures.
        episodes: how many.
        longest: break an episode off after so many simulated seconds; 0 for never.
    """
    for number in range(episodes):
        yield tuple(
            play(
                *(game.world, game.players),
                between=game.between,
                first=number,
                cycles_max=math.ceil(longest / game.world.cycle_seconds) or None,
            )[0]
            for game in games
        )


@dataclass(frozen=True)
class Comparison:
    """A measure of the same episodes, in one game or in two.

    Attributes:
        measure: the compared measure.
        values: of the episodes, by game.
    """

    measure: Measure
    values: Sequence[Sequence[float]]

    @classmethod
    def of(cls, measure: Measure, played: Sequence[tuple[EpisodeResult, ...]]) -> Comparison:
        """Return how a measure was in episodes that `play_alike` yielded."""
        return cls(
            measure, [[measure.of(one) for one in game] for game in zip(*played, strict=True)]
        )

    @property
    def estimates(self) -> list[Estimate]:
        """The mean in each game."""
        return [estimate(values) for values in self.values]

    @property
    def difference(self) -> Estimate:
        """The mean lead of the first game over the second, paired by episode."""
        return estimate([a - b for a, b in zip(*self.values, strict=True)])

    @property
    def verdict(self) -> str:
        """Whether the first game is ``better`` or ``worse``; "" if that is not certain."""
        found = self.difference
        if found.low is None or found.high is None or found.low <= 0.0 <= found.high:
            return ""
        return "better" if (found.low > 0.0) == (self.measure.better == MORE) else "worse"

    def to_json(self) -> dict[str, Any]:
        """Return all figures as plain data."""
        keys = ("evaluated", "against")
        data: dict[str, Any] = {"unit": self.measure.unit, "better": self.measure.better}
        for key, found, values in zip(keys, self.estimates, self.values, strict=False):
            plain = [value if math.isfinite(value) else None for value in values]
            data[key] = asdict(found) | {"episodes": plain}
        if len(self.values) > 1:
            data["difference"] = asdict(self.difference) | {"verdict": self.verdict}
        return data


def endings(played: Sequence[tuple[EpisodeResult, ...]]) -> list[dict[str, int]]:
    """Return how often episodes ended in which way, by game."""
    return [
        dict(Counter(result.ended or "broken off" for result in game))
        for game in zip(*played, strict=True)
    ]
