"""Agents that get nowhere although their mates do, without knowing any speed of the game.

An agent is still while its outer states stay the same and it stays near a place. How near follows
from the strides of its domain's agents, and how long is too long from its mates in the same state:
where many wait, waiting is no fault.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from typing import NamedTuple

SAMPLES_MIN = 30
"""Minimum number of samples in which a stuck agent was still."""

WATCHED_MIN = 60
"""Minimum number of samples that show what is usual; earlier, only few stays have ended."""

MATES_MIN = 10
"""Minimum number of agents that are compared; else those in the surrounding state are, too."""

TIMES = 2.0
"""A stuck agent has been still for so many times as long as its mates usually are."""

RARE = 0.005
"""Share of their time that mates spend in stays which are too long to be usual."""

MANY = 0.1
"""Share of an agent's mates that are as still as it is, if they just wait."""

STRIDE_QUANTILE = 0.75
"""Quantile of the ways of a domain's agents between two samples that counts as a stride."""

Place = tuple[float, float]


class Doing(NamedTuple):
    """What an agent does: agents that do the same are mates.

    Attributes:
        path: labels of the active states, outermost first.
    """

    domain: str
    behavior: str
    path: tuple[str, ...]


class Stuck(NamedTuple):
    """How long an agent has been still, and most of its mates at most, s."""

    seconds: float
    mates: float


class _Anchor(NamedTuple):
    doing: Doing
    place: Place | None
    since: float

    def is_left(self, doing: Doing, place: Place | None, stride: float) -> bool:
        """Whether an agent that does something else, or is somewhere else, has gone on."""
        if place is None or self.place is None:
            return doing != self.doing or place is not self.place
        return doing != self.doing or math.dist(place, self.place) > stride


class Stillness:
    """How long each agent has been still."""

    def __init__(self) -> None:
        self._anchors: dict[str, _Anchor] = {}
        self._ended: dict[Doing, Counter[int]] = defaultdict(Counter)
        self._places: Mapping[str, Place] = {}
        self._now = -math.inf
        self._samples = 0
        self._sample_s = 0.0

    def take(
        self, seconds: float, doings: Mapping[str, Doing], places: Mapping[str, Place]
    ) -> None:
        """Take a sample, at about equal intervals.

        Args:
            seconds: time of the swarm, s; if it is earlier than before, all begins anew.
            doings: what each performing agent does, by name.
            places: positions, m, by name, as far as they are known.
        """
        if seconds < self._now:
            self.__init__()  # type: ignore[misc]
        strides = self._strides(doings, places)
        before, self._anchors = self._anchors, {}
        for name, doing in doings.items():
            place = places.get(name)
            if place is not None and len(doing.path) > 1:
                doing = doing._replace(path=doing.path[:-1])  # an agent in a corner turns, too
            anchor = before.get(name)
            if anchor is None or anchor.is_left(doing, place, strides[doing.domain]):
                if anchor is not None:
                    for pool in _pools(anchor.doing):
                        self._ended[pool][round(seconds - anchor.since)] += 1
                anchor = _Anchor(doing, place, seconds)
            self._anchors[name] = anchor
        self._sample_s = seconds - self._now if math.isfinite(self._now) else 0.0
        self._places, self._now = dict(places), seconds
        self._samples += 1

    def _strides(
        self, doings: Mapping[str, Doing], places: Mapping[str, Place]
    ) -> dict[str, float]:
        """Return the stride of each domain's agents since the last sample, m."""
        ways: dict[str, list[float]] = defaultdict(list)
        for name, doing in doings.items():
            if name in places and name in self._places:
                ways[doing.domain].append(math.dist(places[name], self._places[name]))
        strides = {d: sorted(w)[int(STRIDE_QUANTILE * len(w))] for d, w in ways.items()}
        return defaultdict(float, strides)

    def stuck(self) -> dict[str, Stuck]:
        """Return the agents that have been still for much longer than their mates."""
        if self._samples < WATCHED_MIN:
            return {}
        still = {name: self._now - anchor.since for name, anchor in self._anchors.items()}
        pools: dict[Doing, list[float]] = defaultdict(list)
        for name, anchor in self._anchors.items():
            for pool in _pools(anchor.doing):
                pools[pool].append(still[name])
        found = {}
        for name, seconds in still.items():
            if not seconds or seconds < SAMPLES_MIN * self._sample_s:
                continue
            doing = self._anchors[name].doing
            mates = next((p for p in _pools(doing) if len(pools[p]) >= MATES_MIN), None)
            if mates is None or seconds <= TIMES * (usual := self._usual(mates)):
                continue
            alike = sum(other >= seconds / TIMES for other in pools[mates])
            if alike <= max(1.0, MANY * len(pools[mates])):
                found[name] = Stuck(seconds, usual)
        return found

    def _usual(self, pool: Doing) -> float:
        """Return the longest stay that is usual in a state, s."""
        ended = self._ended[pool]
        left = RARE * sum(seconds * count for seconds, count in ended.items())
        for seconds in sorted(ended, reverse=True):
            left -= seconds * ended[seconds]
            if left < 0.0:
                return float(seconds)
        return 0.0


def _pools(doing: Doing) -> Iterable[Doing]:
    """Return what agents with the same, or a surrounding, state do; the closest first."""
    return (doing._replace(path=doing.path[:end]) for end in range(len(doing.path), -1, -1))
