"""Causes of late commands: for each, the moment when it was due.

Commands of one kind (leave this state, go to that one) have a common cause, say, that the ball is
nearer than some distance, or that a flag was raised. A guess of that cause gives for each command
the time when it was due, and so its delay; with a good guess, all delays of a person are about
equal. So the cause and the delay are estimated together, as a distribution over both:

- *The cause*: one feature passed some threshold, came nearer to or farther from straight
  ahead, or took a value. What takes values happens at a known moment; these have half of the
  probability. Of each half, all features are as likely, and of one feature all its thresholds. A
  command that was not given while the guess held speaks against it, the more the longer it held.
- *The delay*: see `hitab_core.assistant.lateness`.
- One command in ten is taken to answer to something else.

A threshold that was passed earlier explains the same commands with a longer delay. So whether the
person is in time is decided first; then the moment of each command is the most probable one, not a
mean between several. Who takes over from an automaton corrects one of its last changes of state,
or a missing change, whichever fits.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from hitab_core.assistant.lateness import (
    ALONE,
    LATEST,
    MODELS,
    OTHERWISE,
    TINY,
    LateCommand,
    Lateness,
    masses,
)
from hitab_core.domain import FeatureKind, Scale
from hitab_core.numeric.arrays import Booleans, Floats, Integers

P_IMMEDIATE = 0.1
"""Probability that a command answers to a condition that held when its state began, relative to
later conditions. The former guesses are more numerous, since half of all thresholds are passed
from the beginning."""

EVENTS = 0.5
"""Probability that a cause is that a feature takes a value, if some are measured, too."""

NEAR = 0.15
"""Moments nearer than this, s, count together: they say the same of how a person acts."""

THRESHOLDS_MAX = 60
"""The most thresholds of one feature that are compared."""


def settled(
    commands: Sequence[LateCommand],
    scales: Sequence[Scale],
    before: Lateness,
    told: Sequence[float] = (),
) -> tuple[list[int], list[Floats], Lateness]:
    """Return the moment at which each command was due, and the lateness of the person.

    Args:
        commands: commands of one person.
        scales: scales of the features.
        before: lateness of the person as estimated before these commands.
        told: delays of other commands that the person has told, s.

    Returns:
        Indices of moments, and after these of the changes of state that a command may correct; of
        each command, how probable each of these is; and the lateness.
    """
    kinds: dict[tuple[str, str], list[int]] = {}
    for i, command in enumerate(commands):
        kinds.setdefault((command.state, command.label), []).append(i)
    log_odds = np.log(before.odds + TINY)
    for delay in told:
        mass = masses(np.array([delay]))[0, 0]
        log_odds += np.log((1.0 - OTHERWISE) * mass + OTHERWISE * ALONE / LATEST)
    found = {}
    for kind, members in kinds.items():
        others = [c for c in commands if c.state == kind[0] and c.label != kind[1]]
        found[kind] = _explanations([commands[i] for i in members], others, scales)
        log_odds += _log_sum(found[kind].log_likelihood)
    odds = np.exp(log_odds - log_odds.max())
    after = Lateness(odds / odds.sum())
    weights = [np.zeros(0)] * len(commands)
    for kind, members in kinds.items():
        for i, of_moments in zip(members, found[kind].weights(after), strict=True):
            weights[i] = of_moments
    return list(map(_due, commands, weights)), weights, after


def _due(command: LateCommand, weights: Floats) -> int:
    """Return the most probable moment, or change of state if such a one is more probable."""
    count = len(command.delays)
    if weights[count:].sum() > 0.5:
        return count + int(weights[count:].argmax())
    return _mode(command.delays, weights[:count])


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
        surprising: shape (guesses,), whether the cause cannot be foreseen.
        log_likelihood: shape (guesses, models), with the guess's own probability.
    """

    commands: Sequence[LateCommand]
    first: Integers
    surprising: Booleans
    log_likelihood: Floats

    def parts(self, i: int) -> tuple[Floats, Floats, Floats]:
        """Return the likelihood of a command, and its parts: it answers to a guess, or corrects.

        Returns:
            Shapes (guesses, models), (guesses, models) and (models,).
        """
        command, first = self.commands[i], self.first[:, i]
        change = command.odds_of_change
        answered = (1.0 - change) * (1.0 - OTHERWISE) * self.of_guesses(command.masses, first, 0.0)
        answered[first == 0] *= P_IMMEDIATE
        corrected = change * command.changes.sum(axis=0) / max(1, len(command.changed))
        other = (1.0 - change) * OTHERWISE / len(command.delays)
        return answered + corrected + other + TINY, answered, corrected

    def of_guesses(self, of_moments: Floats, moments: Integers, never: float) -> Floats:
        """Return what something is for each guess, by whether its cause can be foreseen.

        Args:
            of_moments: what it is for all moments, shape (2, moments, models).
            moments: shape (guesses,), which moment counts for each guess, -1 for none.
            never: what it is for none.
        """
        found = np.concatenate([of_moments, np.full((2, 1, MODELS), never)], axis=1)
        return np.asarray(found[self.surprising.astype(np.intp), moments])

    def weights(self, lateness: Lateness) -> list[Floats]:
        """Return how probably each command was meant for each moment, and after these change."""
        likely = self.log_likelihood + np.log(lateness.decided.odds + TINY)
        odds = np.exp(likely - likely.max())
        odds /= odds.sum()
        models = odds.sum(axis=0)
        found: list[Floats] = []
        for i, command in enumerate(self.commands):
            likelihood, answered, corrected = self.parts(i)
            change = float((odds * corrected / likelihood).sum())
            changes = command.changes @ models + TINY
            answers = (odds * answered / likelihood).sum(axis=1)
            known = self.first[:, i] >= 0
            moments = np.zeros(len(command.delays))
            np.add.at(moments, self.first[known, i], answers[known])
            usual = command.masses[0] @ models + TINY
            rest = max(0.0, 1.0 - float(moments.sum()))
            moments += rest * usual / usual.sum()
            moments *= (1.0 - change) / moments.sum()
            found.append(np.concatenate([moments, change * changes / max(changes.sum(), TINY)]))
        return found


def _mode(delays: Floats, weights: Floats) -> int:
    """Return the most probable moment among those near the most probable time."""
    near = np.abs(delays[:, None] - delays) <= NEAR + 1e-6
    there = near[int((near @ weights).argmax())]
    return int(np.where(there, weights, -1.0).argmax())


def _explanations(
    commands: Sequence[LateCommand], others: Sequence[LateCommand], scales: Sequence[Scale]
) -> _Explanations:
    guesses, guessed, surprising = _guesses(commands, others, scales)
    firsts = _firsts(guesses, [*commands, *others])
    log_likelihood = np.repeat(np.log(guessed)[:, None], MODELS, axis=1)
    found = _Explanations(commands, firsts[:, : len(commands)], surprising, log_likelihood)
    for i in range(len(commands)):
        log_likelihood += np.log(found.parts(i)[0])
    for other, held in zip(others, firsts.T[len(commands) :], strict=True):
        patience = found.of_guesses(other.survival, held, 1.0)
        log_likelihood += np.log((1.0 - OTHERWISE) * patience + OTHERWISE)
    return found


def _guesses(
    commands: Sequence[LateCommand], others: Sequence[LateCommand], scales: Sequence[Scale]
) -> tuple[Booleans, Floats, Booleans]:
    """Return the possible causes of commands.

    Returns:
        shape (guesses, moments of the commands and then of the others), in which moments each
            guess holds; and shape (guesses,), how probable it is at first, and whether it cannot
            be foreseen.
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
        return np.zeros((1, len(values)), np.bool_), np.ones(1), np.zeros(1, np.bool_)
    shares = {True: 1.0 - EVENTS, False: EVENTS} if len({*measured}) > 1 else {measured[0]: 1.0}
    odds = [
        shares[kind] / (measured.count(kind) * len(of_feature))
        for of_feature, kind in zip(found, measured, strict=True)
        for _ in of_feature
    ]
    surprising = [not kind for of, kind in zip(found, measured, strict=True) for _ in of]
    return np.concatenate(found), np.array(odds), np.array(surprising)


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
