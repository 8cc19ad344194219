"""Lateness: when late commands were due, learned from the commands themselves.

A person who commands a moving robot is late by an unknown time. But commands of one
kind (leave this state, go to that one) have a common cause, say, that the ball is nearer than some
distance, or that a flag was raised. A guess of that cause gives for each command the time when it
was due, and so its delay; with a good guess, all delays of a person are about equal. So the cause
and the delay are estimated together, as a distribution over both:

- *The delay*: log-normal, with the median and the spread on a grid (`Lateness`). It begins as wide
  as people are: 95 % of the medians between 0.2 and 1.2 s.
- *The cause*: one feature passed some threshold, came nearer to or farther from straight
  ahead, or took a value; all features are as likely, and of one feature all its thresholds. A
  command that was not given while the guess held speaks against it, the more the longer it held.
- One command in ten is taken to answer to something else.

The moment of a command is the median of this distribution. The only command of its kind gives
little evidence, so it counts as due the person's usual delay before it came. A person who takes
over from an automaton corrects its last change of state, or a missing change, whichever fits.
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
"""The grid: medians, s, and standard deviations of the logarithm."""

OTHERWISE = 0.1
"""The part of commands that have another cause than the others of their kind."""

P_IMMEDIATE = 0.1
"""Probability that a command answers to a condition that held when its state began, relative to
later conditions. The former guesses are more numerous, since half of all thresholds are passed
from the beginning."""

SHORTEST = 0.05
"""No delay is shorter, s: a person's eyes and fingers take that long."""

TINY = 1e-300
"""Keeps logarithms finite."""

THRESHOLDS_MAX = 60
"""The most thresholds of one feature that are compared."""


@dataclass(frozen=True)
class LateCommand:
    """A command that came late.

    Attributes:
        state, label: the state left, and the next state.
        delays: shape (n,), how long before the command each moment was for which it may have been
            meant, in the person's seconds, descending.
        values: shape (n, m), of the features in these moments.
        changed: time from the automaton's last change of state to the command, s; None if the
            command cannot correct that change.
        corrects: whether the command corrects that change; None if unknown.
    """

    state: str
    label: str
    delays: Floats
    values: Floats
    changed: float | None = None
    corrects: bool | None = None

    @property
    def odds_of_change(self) -> float:
        """Probability, before looking at the time, that the command corrects the change."""
        if self.changed is None:
            return 0.0
        return 0.5 if self.corrects is None else float(self.corrects)


@dataclass
class Lateness:
    """Lateness of a person's commands: probabilities over the grid.

    Attributes:
        odds: shape (medians, spreads), adding up to 1.
    """

    odds: Floats = field(default_factory=lambda: _prior())

    @property
    def median(self) -> float:
        """The delay, s, that half of the commands are expected to exceed."""
        return float(np.exp(np.sum(self.odds * np.log(MEDIANS)[:, None])))

    def density(self, delays: Floats) -> Floats:
        """Return how probable delays are, shape (n,), per second."""
        return np.asarray((_density(delays) * self.odds).sum(axis=(1, 2)))


def _prior() -> Floats:
    middle = math.log(math.sqrt(SOONEST * LATEST))
    width = math.log(LATEST / SOONEST) / 4.0
    odds = np.exp(-0.5 * ((np.log(MEDIANS) - middle) / width) ** 2)
    grid = np.repeat(odds[:, None], len(SPREADS), axis=1)
    return np.asarray(grid / grid.sum())


def _density(delays: Floats) -> Floats:
    """Return how probable delays are: shape (*delays, medians, spreads), per second."""
    seconds = np.maximum(delays, SHORTEST)[..., None, None]
    z = (np.log(seconds) - np.log(MEDIANS)[:, None]) / SPREADS
    return np.asarray(np.exp(-0.5 * z**2) / (seconds * SPREADS * math.sqrt(2.0 * math.pi)))


def _survival(seconds: Floats) -> Floats:
    """Return how probable it is that a delay is longer: shape (*seconds, medians, spreads)."""
    z = (np.log(np.maximum(seconds, 1e-3))[..., None, None] - np.log(MEDIANS)[:, None]) / SPREADS
    return np.asarray(0.5 * _erfc(z / math.sqrt(2.0)))


_erfc = np.vectorize(math.erfc, otypes=[np.float64])


def settled(
    commands: Sequence[LateCommand], scales: Sequence[Scale], before: Lateness
) -> tuple[list[int], Lateness]:
    """Return the moment at which each command was due, and the lateness of the person.

    Args:
        commands: commands of one person.
        scales: scales of the features.
        before: lateness of the person as estimated before these commands.

    Returns:
        Indices of moments, -1 for the change of state that a command corrects; and the lateness.
    """
    kinds: dict[tuple[str, str], list[int]] = {}
    for i, command in enumerate(commands):
        kinds.setdefault((command.state, command.label), []).append(i)
    log_odds = np.log(before.odds + TINY)
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
        fitting: shape (guesses, commands, medians, spreads), how probable it is that a command
            answers to a guess.
        changing: the same shape, how probable it is that a command corrects a change of state.
        log_likelihood: shape (guesses, medians, spreads), with the guess's own probability.
    """

    commands: Sequence[LateCommand]
    first: Integers
    fitting: Floats
    changing: Floats
    log_likelihood: Floats

    def dues(self, lateness: Lateness) -> list[int]:
        """Return the median of the moments that each command may have been meant for."""
        likelihood = self.log_likelihood + np.log(lateness.odds + TINY)
        odds = np.exp(likelihood - likelihood.max())
        odds /= odds.sum()
        dues = []
        for i, command in enumerate(self.commands):
            if (odds * self.changing[:, i]).sum() > 0.5:
                dues.append(-1)
                continue
            answers = (odds * self.fitting[:, i]).sum(axis=(1, 2))
            known = self.first[:, i] >= 0
            weights = np.bincount(
                self.first[known, i], answers[known], minlength=len(command.delays)
            )
            usual = (_density(command.delays) * odds.sum(axis=0)).sum(axis=(1, 2))
            total = usual.sum()
            rest = max(0.0, 1.0 - float(weights.sum()))
            weights = weights + (rest * usual / total if total > 0 else rest / len(usual))
            dues.append(int(np.searchsorted(np.cumsum(weights), 0.5 * weights.sum())))
        return dues


def _explanations(
    commands: Sequence[LateCommand], others: Sequence[LateCommand], scales: Sequence[Scale]
) -> _Explanations:
    guesses, guessed = _guesses(commands, others, scales)
    firsts = _firsts(guesses, [*commands, *others])
    first = firsts[:, : len(commands)]
    grid = (len(MEDIANS), len(SPREADS))
    fitting = np.empty((len(guesses), len(commands), *grid))
    changing = np.empty_like(fitting)
    log_likelihood = np.log(guessed)[:, None, None] + np.zeros((1, *grid))
    for i, command in enumerate(commands):
        length = max(float(command.delays[0]), SHORTEST)
        density = np.concatenate([_density(command.delays), np.zeros((1, *grid))])
        change = command.odds_of_change
        answered = (1.0 - change) * (1.0 - OTHERWISE) * density[first[:, i]]
        answered[first[:, i] == 0] *= P_IMMEDIATE
        corrected = change * _density(np.array(command.changed or SHORTEST))
        likelihood = answered + corrected + (1.0 - change) * OTHERWISE / length + TINY
        fitting[:, i] = answered / likelihood
        changing[:, i] = corrected / likelihood
        log_likelihood += np.log(likelihood)
    for other, held in zip(others, firsts.T[len(commands) :], strict=True):
        patience = np.concatenate(
            [_survival(other.delays), np.ones((1, len(MEDIANS), len(SPREADS)))]
        )
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
    if not found:
        return np.zeros((1, len(values)), np.bool_), np.ones(1)
    odds = [1.0 / (len(found) * len(of_feature)) for of_feature in found for _ in of_feature]
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
