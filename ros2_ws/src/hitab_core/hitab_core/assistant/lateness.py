"""Lateness: how late a person's commands come, learned from the commands themselves.

A person who commands a moving robot is late by an unknown time; or in time, since the person saw
it coming, or the world crawls; or in time for what can be foreseen, such as a threshold, and late
for what surprises: something is so that was not so, or the automaton does what is wrong. Each of
these is as likely at first:

- in time: the delay is half-normal, with the spread on a grid;
- late: it is log-normal, with the median and the spread on a grid, as wide as people are: 95 % of
  the medians between 0.2 and 1.2 s;
- surprised: in time or late, as the cause is; late by as much as people are, whoever it is.

Who watches an automaton may wait before taking over; that is no part of the person's delay. When
commands were due is in `hitab_core.assistant.causes`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from hitab_core.numeric.arrays import Floats

SOONEST, LATEST = 0.2, 1.2
"""Medians of people's delays, s: 95 % of them lie in between at first."""

MEDIANS = np.geomspace(0.1, 2.4, 21)
SPREADS = np.array([0.15, 0.3, 0.5])
"""The grid of who is late: medians, s, and standard deviations of the logarithm."""

IN_TIME = np.array([0.05, 0.1, 0.2])
"""The grid of who is in time: standard deviations of the delay, s."""

WAYS = np.array([1.0, 1.0, 1.0]) / 3.0
"""Probability, before any command, that a person is in time, late, or late if surprised."""

OTHERWISE = 0.1
"""The part of commands that have another cause than the others of their kind."""

STAYING = 0.9
"""Probability that a command of the state that is active corrects a change that came too early."""

WAITS = np.linspace(0.0, 0.5, 6)
"""How long somebody who watches waits before taking over, s: these are equally probable."""

ALONE = 0.1
"""How long a moment is taken to last of which no other is known, s."""

TINY = 1e-300
"""Keeps logarithms finite."""


@dataclass(frozen=True)
class LateCommand:
    """A command that may have come late.

    Attributes:
        state, label: the state left, and the next state.
        delays: shape (n,), how long before the command each moment was for which it may have been
            meant, in the person's seconds, descending.
        values: shape (n, m), of the features in these moments.
        watched: whether the person let the automaton decide until then.
        changed: times from changes of state by the automaton, which the command may correct, to
            the command, s.
    """

    state: str
    label: str
    delays: Floats
    values: Floats
    watched: bool = False
    changed: tuple[float, ...] = ()

    @cached_property
    def masses(self) -> Floats:
        """How probably it came after each of its delays; see `masses`."""
        return masses(self.delays, waits=self.watched)

    @cached_property
    def survival(self) -> Floats:
        """How probably it would have come later than after each delay; see `masses`."""
        return _survival(self.delays, waits=self.watched)

    @cached_property
    def changes(self) -> Floats:
        """How probably it came after each change, shape (changes, models)."""
        alone = (masses(np.array([delay]))[1] for delay in self.changed)
        return np.concatenate([np.empty((0, MODELS)), *alone])

    @property
    def odds_of_change(self) -> float:
        """Probability, before looking at the time, that the command corrects a change."""
        if not self.changed:
            return 0.0
        return STAYING if self.state == self.label else 0.5


@dataclass
class Lateness:
    """Lateness of a person's commands: probabilities over the grids.

    Attributes:
        odds: shape (models,), adding up to 1: in time, late, late if surprised.
    """

    odds: Floats = field(default_factory=lambda: _prior())

    @property
    def decided(self) -> Lateness:
        """The lateness, given the most probable way to be late; in time if nothing tells."""
        ways = np.bincount(_WAY, self.odds).round(9)  # so that rounding decides no tie
        odds = np.where(ways.argmax() == _WAY, self.odds, 0.0)
        return Lateness(odds / odds.sum())

    @property
    def median(self) -> float:
        """The delay, s, that half of the commands are expected to exceed if nothing surprises."""
        return float(np.exp(np.sum(self.decided.odds * np.log(_HALF))))

    def density(self, delays: Floats, *, waits: bool) -> Floats:
        """Return how probable delays are if nothing surprises, shape (n,); see `masses`."""
        return np.asarray(masses(delays, waits=waits)[0] @ self.odds)


_MIDDLE, _WIDTH = math.log(SOONEST * LATEST) / 2.0, math.log(LATEST / SOONEST) / 4.0
_LATE = np.exp(-0.5 * ((np.log(MEDIANS) - _MIDDLE) / _WIDTH) ** 2)
_GRID = np.repeat(_LATE, len(SPREADS)) / (len(SPREADS) * _LATE.sum())
"""How probable each late model is for somebody who is late."""

_WAY = np.repeat([0, 1, 2], [len(IN_TIME), len(_GRID), len(IN_TIME)])
"""Of each model of a delay: in time, late, or late if surprised."""

_HALF = np.concatenate([0.6745 * IN_TIME, np.repeat(MEDIANS, len(SPREADS)), 0.6745 * IN_TIME])
"""The median delay of each model if nothing surprises, s."""

MODELS = len(_WAY)
"""How many models of a delay there are."""


def _prior() -> Floats:
    same = np.full(len(IN_TIME), 1.0 / len(IN_TIME))
    return np.asarray(np.concatenate([same, _GRID, same]) * WAYS[_WAY])


def _above(z: Floats) -> Floats:
    """Return how probably a standard normal number is larger, to 0.0003."""
    return np.asarray(0.5 - 0.5 * np.tanh(math.sqrt(2.0 / math.pi) * (z + 0.044715 * z**3)))


def _survival(seconds: Floats, *, waits: bool = False) -> Floats:
    """Return how probable it is that a delay is longer, in the shape of `masses`."""
    if waits:
        return np.asarray(_survival(seconds[..., None] - WAITS).mean(axis=-2))
    z = (np.log(np.maximum(seconds, 1e-3))[..., None, None] - np.log(MEDIANS)[:, None]) / SPREADS
    late = _above(z).reshape(*seconds.shape, -1)
    in_time = 2.0 * _above(np.maximum(seconds, 0.0)[..., None] / IN_TIME)
    surprised = np.broadcast_to((late @ _GRID)[..., None], in_time.shape)
    kinds = (np.concatenate([in_time, late, rest], axis=-1) for rest in (in_time, surprised))
    return np.stack([*kinds])


def masses(delays: Floats, *, waits: bool = False) -> Floats:
    """Return how probable delays are, each together with what is nearer to it than to another.

    Args:
        delays: shape (n,), descending, s.
        waits: whether the person may have waited before.

    Returns:
        Shape (2, n, models): if what the person reacts to can be foreseen, and if it surprises.
    """
    step = float(np.median(delays[:-1] - delays[1:])) if len(delays) > 1 else ALONE
    between = (delays[1:] + delays[:-1]) / 2.0
    edges = np.concatenate([[delays[0] + step / 2.0], between, [delays[-1] - step / 2.0]])
    return np.diff(_survival(edges, waits=waits), axis=1)
