"""Lateness: when late commands were due, learned from the commands themselves.

A person who commands a moving robot is late by an unknown time, or in time: the person saw it
coming, or the world crawls. But commands of one kind (leave this state, go to that one) have a
common cause, say, that the ball is nearer than some distance, or that a flag was raised. A guess of
that cause gives for each command the time when it was due, and so its delay; with a good guess, all
delays of a person are about equal. So the cause and the delay are estimated together, as a
distribution over both:

- *The delay*: in time, half-normal with the spread on a grid; or late, log-normal, with the median
  and the spread on a grid (`Lateness`). Both are as likely at first, and the late ones as wide as
  people are: 95 % of the medians between 0.2 and 1.2 s.
- *The cause*: one feature passed some threshold, came nearer to or farther from straight
  ahead, or took a value. What takes values happens at a known moment; these have half of the
  probability. Of each half, all features are as likely, and of one feature all its thresholds. A
  command that was not given while the guess held speaks against it, the more the longer it held.
- One command in ten is taken to answer to something else.

A threshold that was passed earlier explains the same commands with a longer delay. So the more
probable of *in time* and *late* is decided first, and then the moment of each command is the most
probable one, not a mean between several. A person who takes over from an automaton has watched, and
may have waited; the command corrects one of its last changes of state, or a missing change,
whichever fits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from hitab_core.domain import FeatureKind, Scale
from hitab_core.numeric.arrays import Booleans, Floats, Integers

SOONEST, LATEST = 0.2, 1.2
"""Medians of people's delays, s: 95 % of them lie in between at first."""

MEDIANS = np.geomspace(0.1, 2.4, 21)
SPREADS = np.array([0.15, 0.3, 0.5])
"""The grid of who is late: medians, s, and standard deviations of the logarithm."""

IN_TIME = np.array([0.05, 0.1, 0.2])
"""The grid of who is in time: standard deviations of the delay, s."""

PUNCTUAL = 0.5
"""Probability, before any command, that a person is in time."""

OTHERWISE = 0.1
"""The part of commands that have another cause than the others of their kind."""

P_IMMEDIATE = 0.1
"""Probability that a command answers to a condition that held when its state began, relative to
later conditions. The former guesses are more numerous, since half of all thresholds are passed
from the beginning."""

EVENTS = 0.5
"""Probability that a cause is that a feature takes a value, if some are measured, too."""

WAITS = np.linspace(0.0, 0.5, 6)
"""How long somebody who watches waits before taking over, s: these are equally probable."""

NEAR = 0.15
"""Moments nearer than this, s, count together: they say the same of how a person acts."""

ALONE = 0.1
"""How long a moment is taken to last of which no other is known, s."""

TINY = 1e-300
"""Keeps logarithms finite."""

THRESHOLDS_MAX = 60
"""The most thresholds of one feature that are compared."""


@dataclass(frozen=True)
class LateCommand:
    """A command that may have come late.

    Attributes:
        state, label: the state left, and the next state.
        delays: shape (n,), how long before the command each moment was for which it may have been
            meant, in the person's seconds, descending.
        values: shape (n, m), of the features in these moments.
        watched: whether the person took over from the automaton to give it.
        changed: times from changes of state by the automaton, which the command may correct, to
            the command, s.
    """

    state: str
    label: str
    delays: Floats
    values: Floats
    watched: bool = False
    changed: tuple[float, ...] = ()

    @property
    def masses(self) -> Floats:
        """How probably it came after each of its delays, shape (n, models)."""
        return masses(self.delays, watched=self.watched)

    @property
    def changes(self) -> Floats:
        """How probably it came after each change, shape (changes, models)."""
        alone = (masses(np.array([delay]), watched=self.watched) for delay in self.changed)
        return np.concatenate([*alone])

    @property
    def odds_of_change(self) -> float:
        """Probability, before looking at the time, that the command corrects a change."""
        return 0.5 if self.changed else 0.0


@dataclass
class Lateness:
    """Lateness of a person's commands: probabilities over the grids.

    Attributes:
        odds: shape (models,), adding up to 1: first in time, then late.
    """

    odds: Floats = field(default_factory=lambda: _prior())

    @property
    def is_in_time(self) -> bool:
        """Whether the person is in time, more probably than not."""
        return float(self.odds[: len(IN_TIME)].sum()) >= 0.5

    @property
    def decided(self) -> Lateness:
        """The lateness, given whether the person is in time."""
        odds = self.odds.copy()
        odds[len(IN_TIME) :] *= not self.is_in_time
        odds[: len(IN_TIME)] *= self.is_in_time
        return Lateness(odds / odds.sum())

    @property
    def median(self) -> float:
        """The delay, s, that half of the commands are expected to exceed."""
        return float(np.exp(np.sum(self.decided.odds * np.log(_HALF))))

    def density(self, delays: Floats, *, watched: bool = False) -> Floats:
        """Return how probable delays are, shape (n,); see `masses`."""
        return np.asarray(masses(delays, watched=watched) @ self.odds)


def _prior() -> Floats:
    middle = math.log(math.sqrt(SOONEST * LATEST))
    width = math.log(LATEST / SOONEST) / 4.0
    odds = np.exp(-0.5 * ((np.log(MEDIANS) - middle) / width) ** 2)
    late = np.repeat(odds, len(SPREADS))
    in_time = np.full(len(IN_TIME), PUNCTUAL / len(IN_TIME))
    return np.concatenate([in_time, (1.0 - PUNCTUAL) * late / late.sum()])


_HALF = np.concatenate([0.6745 * IN_TIME, np.repeat(MEDIANS, len(SPREADS))])
"""The median delay of each model, s."""

MODELS = len(_HALF)
"""How many models of a delay there are."""


def _above(z: Floats) -> Floats:
    """Return how probably a standard normal number is larger, to 0.0003."""
    return np.asarray(0.5 - 0.5 * np.tanh(math.sqrt(2.0 / math.pi) * (z + 0.044715 * z**3)))


def _survival(seconds: Floats, *, watched: bool = False) -> Floats:
    """Return how probable it is that a delay is longer: shape (*seconds, models)."""
    if watched:
        return np.asarray(_survival(seconds[..., None] - WAITS).mean(axis=-2))
    z = (np.log(np.maximum(seconds, 1e-3))[..., None, None] - np.log(MEDIANS)[:, None]) / SPREADS
    in_time = 2.0 * _above(np.maximum(seconds, 0.0)[..., None] / IN_TIME)
    return np.concatenate([in_time, _above(z).reshape(*seconds.shape, -1)], axis=-1)


def masses(delays: Floats, *, watched: bool = False) -> Floats:
    """Return how probable delays are, each together with what is nearer to it than to another.

    Args:
        delays: shape (n,), descending, s.
        watched: whether the person watched, and may have waited before.

    Returns:
        Shape (n, models).
    """
    step = float(np.median(delays[:-1] - delays[1:])) if len(delays) > 1 else ALONE
    between = (delays[1:] + delays[:-1]) / 2.0
    edges = np.concatenate([[delays[0] + step / 2.0], between, [delays[-1] - step / 2.0]])
    return np.diff(_survival(edges, watched=watched), axis=0)


def settled(
    commands: Sequence[LateCommand],
    scales: Sequence[Scale],
    before: Lateness,
    told: Sequence[tuple[float, bool]] = (),
) -> tuple[list[int], Lateness]:
    """Return the moment at which each command was due, and the lateness of the person.

    Args:
        commands: commands of one person.
        scales: scales of the features.
        before: lateness of the person as estimated before these commands.
        told: delays of other commands that the person has told, s, and whether the person had
            watched.

    Returns:
        Indices of moments, and after these of the changes of state that a command may correct; and
        the lateness.
    """
    kinds: dict[tuple[str, str], list[int]] = {}
    for i, command in enumerate(commands):
        kinds.setdefault((command.state, command.label), []).append(i)
    log_odds = np.log(before.odds + TINY)
    for delay, watched in told:
        mass = masses(np.array([delay]), watched=watched)[0]
        log_odds += np.log((1.0 - OTHERWISE) * mass + OTHERWISE * ALONE / LATEST)
    found = {}
    for kind, members in kinds.items():
        others = [c for c in commands if c.state == kind[0] and c.label != kind[1]]
        found[kind] = _explanations([commands[i] for i in members], others, scales)
        log_odds += _log_sum(found[kind].log_likelihood)
    odds = np.exp(log_odds - log_odds.max())
    after = Lateness(odds / odds.sum())
    dues = [0] * len(commands)
    for kind, members in kinds.items():
        for i, due in zip(members, found[kind].dues(after), strict=True):
            dues[i] = due
    return dues, after


def _log_sum(values: Floats) -> Floats:
    """Return the logarithm of a sum over the first axis."""
    top = values.max(axis=0)
    return np.asarray(top + np.log(np.exp(values - top).sum(axis=0)))


@dataclass
class _Explanations:
    """Possible causes of commands of one kind.

    Attributes:
        commands: commands of the kind.
        first: shape (guesses, commands), the first moment in which each guess holds, or -1.
        fitting: shape (guesses, commands, models), how probable it is that a command answers to a
            guess.
        changing: the same shape, how probable it is that a command corrects a change of state.
        log_likelihood: shape (guesses, models), with the guess's own probability.
    """

    commands: Sequence[LateCommand]
    first: Integers
    fitting: Floats
    changing: Floats
    log_likelihood: Floats

    def dues(self, lateness: Lateness) -> list[int]:
        """Return the most probable of the moments that each command may have been meant for."""
        likelihood = self.log_likelihood + np.log(lateness.decided.odds + TINY)
        odds = np.exp(likelihood - likelihood.max())
        odds /= odds.sum()
        models = odds.sum(axis=0)
        dues = []
        for i, command in enumerate(self.commands):
            if (odds * self.changing[:, i]).sum() > 0.5:
                dues.append(len(command.delays) + int((command.changes @ models).argmax()))
                continue
            answers = (odds * self.fitting[:, i]).sum(axis=1)
            known = self.first[:, i] >= 0
            weights = np.bincount(
                self.first[known, i], answers[known], minlength=len(command.delays)
            )
            usual = command.masses @ models
            rest = max(0.0, 1.0 - float(weights.sum()))
            total = usual.sum()
            weights = weights + (rest * usual / total if total > 0 else rest / len(usual))
            dues.append(_mode(command.delays, weights))
        return dues


def _mode(delays: Floats, weights: Floats) -> int:
    """Return the most probable moment among those near the most probable time."""
    near = np.abs(delays[:, None] - delays) <= NEAR + 1e-6
    there = near[int((near @ weights).argmax())]
    return int(np.where(there, weights, -1.0).argmax())


def _explanations(
    commands: Sequence[LateCommand], others: Sequence[LateCommand], scales: Sequence[Scale]
) -> _Explanations:
    guesses, guessed = _guesses(commands, others, scales)
    firsts = _firsts(guesses, [*commands, *others])
    first = firsts[:, : len(commands)]
    never = np.zeros((1, MODELS))
    fitting = np.empty((len(guesses), len(commands), MODELS))
    changing = np.empty_like(fitting)
    log_likelihood = np.log(guessed)[:, None] + never
    for i, command in enumerate(commands):
        change = command.odds_of_change
        mass = np.concatenate([command.masses, never])
        answered = (1.0 - change) * (1.0 - OTHERWISE) * mass[first[:, i]]
        answered[first[:, i] == 0] *= P_IMMEDIATE
        corrected = change * command.changes.mean(axis=0) if change else never
        other = (1.0 - change) * OTHERWISE / len(command.delays)
        likelihood = answered + corrected + other + TINY
        fitting[:, i] = answered / likelihood
        changing[:, i] = corrected / likelihood
        log_likelihood += np.log(likelihood)
    for other, held in zip(others, firsts.T[len(commands) :], strict=True):
        lasting = _survival(other.delays, watched=other.watched)
        patience = np.concatenate([lasting, np.ones((1, MODELS))])
        log_likelihood += np.log((1.0 - OTHERWISE) * patience[held] + OTHERWISE)
    return _Explanations(commands, first, fitting, changing, log_likelihood)


def _guesses(
    commands: Sequence[LateCommand], others: Sequence[LateCommand], scales: Sequence[Scale]
) -> tuple[Booleans, Floats]:
    """Return the possible causes of commands.

    Returns:
        shape (guesses, moments of the commands and then of the others), in which moments each
            guess holds; and shape (guesses,), how probable it is at first.
    """
    values = np.concatenate([command.values for command in (*commands, *others)])
    own = sum(len(command.values) for command in commands)
    found: list[list[Booleans]] = []
    measured: list[bool] = []
    for column, scale in zip(values.T, scales, strict=True):
        of_feature: list[Booleans] = []
        if not scale.kind.is_measured:
            there = np.unique(column[:own])
            of_feature += [column == value for value in there[~np.isnan(there)]]
        for measure in _measures(column, scale):
            levels = np.unique(measure[:own])
            levels = levels[~np.isnan(levels)]
            edges = (levels[1:] + levels[:-1]) / 2.0
            if len(edges) > THRESHOLDS_MAX:
                edges = edges[np.linspace(0, len(edges) - 1, THRESHOLDS_MAX).astype(int)]
            of_feature += [holds for edge in edges for holds in (measure < edge, measure > edge)]
        if of_feature:
            found.append(of_feature)
            measured.append(scale.kind.is_measured)
    if not found:
        return np.zeros((1, len(values)), np.bool_), np.ones(1)
    shares = {True: 1.0 - EVENTS, False: EVENTS} if len({*measured}) > 1 else {measured[0]: 1.0}
    odds = [
        shares[kind] / (measured.count(kind) * len(of_feature))
        for of_feature, kind in zip(found, measured, strict=True)
        for _ in of_feature
    ]
    return np.concatenate(found), np.array(odds)


def _measures(column: Floats, scale: Scale) -> list[Floats]:
    """Return the measures that may have passed a threshold; on a circle also the size."""
    if scale.kind is FeatureKind.TOROIDAL:
        signed = (column + scale.period / 2.0) % scale.period - scale.period / 2.0
        return [signed, np.abs(signed)]
    return [column] if scale.kind.is_measured else []


def _firsts(holds: Booleans, commands: Sequence[LateCommand]) -> Integers:
    """Return the first moment of each command in which each guess holds, or -1."""
    lengths = [len(command.values) for command in commands]
    begins = np.cumsum([0, *lengths[:-1]])
    never = sum(lengths)
    places = np.arange(never) - np.repeat(begins, lengths)
    first = np.minimum.reduceat(np.where(holds, places, never), begins, axis=1)
    return np.where(first == never, -1, first)
