"""Percepts of an agent in training: readings of everything readable, and the active state."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from hitab_core.automaton import FLAGS, OWN_FEATURES, START
from hitab_core.domain import Domain
from hitab_core.term import Term

READABLE_MAX = 500
"""With more readings, features of two and more parameters are left out."""


@dataclass(frozen=True, slots=True)
class PerceptRecord:
    """One percept of an agent in training.

    Attributes:
        cycle: the world's cycle.
        time: simulated time, s.
        state: label of the active state; after a late command, the state that would have been
            active if the command had come in time.
        readings: values of the features that `readable` returns.
    """

    cycle: int
    time: float
    state: str
    readings: tuple[float, ...]


def readable(domain: Domain, parameters: Sequence[str]) -> tuple[Term, ...]:
    """Return the features read in every moment: the domain's, flags and timers.

    Features of the domain are read for all targets and parameters.

    Args:
        domain: domain of the agent.
        parameters: parameters of the automaton in training.
    """
    things = [*sorted(domain.targets), *parameters]
    features = sorted(domain.features.values(), key=lambda feature: feature.name)
    if sum(len(things) ** len(f.parameters) for f in features) > READABLE_MAX:
        features = [feature for feature in features if len(feature.parameters) < 2]
    terms = [
        Term(feature.name, arguments)
        for feature in features
        for arguments in product(things, repeat=len(feature.parameters))
    ]
    return (*terms, *OWN_FEATURES)


def nearest(moments: Sequence[PerceptRecord], time: float) -> PerceptRecord:
    """Return the moment nearest to a time; of two equally near ones, the later.

    One moment too early costs more than one too late: nothing may have happened yet.
    """
    after = bisect_left(moments, time, key=lambda moment: moment.time)
    around = moments[max(after - 1, 0) : after + 1]
    # Times are sums of steps that no number holds exactly.
    return min(reversed(around), key=lambda moment: round(abs(moment.time - time), 6))


def state_of(active: str) -> str:
    """Return the state that a command leaves: a flag state is left at once."""
    return START if active in FLAGS else active
