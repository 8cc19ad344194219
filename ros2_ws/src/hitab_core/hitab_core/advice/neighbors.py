"""How plausible the next state of an example is, judged by the other examples of its state.

Each example gets the probability of each next state from its neighbors, itself left out. An
example whose own next state is improbable there is either mistaken or stands at a place of which
too little was shown; the two differ in how near the neighbors are, so the model must say how far
an example speaks. It says so by the probability that no boundary lies between two situations,
which falls off exponentially with their distance, as under a random partition of the space
(Mondrian process). With one neighbor of another next state at distance 0 the own one has hardly
any probability left; with that neighbor far off it keeps its share, and nothing can be concluded.

Which features matter, how fast the probability falls off, and how sharply the votes decide, is
taken from the examples where there are enough of them, by how well they predict one another:
features weigh by what each predicts alone, and the probabilities are averaged over settings by
their likelihood. Where there are few examples, all this hardly departs from what suits
demonstrations.

References:
    D. M. Roy, Y. W. Teh, The Mondrian Process, NIPS 2008; M. Balog and others, The Mondrian
    Kernel, UAI 2016: the probability of no cut between two points is a Laplace kernel.
    D. L. Wilson, Asymptotic Properties of Nearest Neighbor Rules Using Edited Data, IEEE
    Transactions on Systems, Man, and Cybernetics 2, 1972: removing what its neighbors contradict.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.arrays import Booleans, Floats, Integers
from hitab_core.domain import FeatureKind, Scale

MISTAKEN = 0.1
"""Expected share of mistaken commands before anything is known."""

FIRM = 10
"""Number of examples that the expected share counts for."""

ROUNDS = 4
"""How often the model is fitted again with less weight for what looks mistaken."""

FALLS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""How fast examples lose their say with distance, in units of the usual fall."""

USUAL_FALL = 4.0
"""Usual boundaries per unit of distance, for one feature; more features, more boundaries."""

SHARPNESS = (1.0, 2.0, 4.0, 8.0, 16.0)
"""Exponents of the votes; 1: votes are probabilities."""

LOUDNESS = (1.0, 100.0)
"""Weight of all votes against none; above 1 even far neighbors outvote ignorance."""

LOUD = 4.0
"""What a loudness above 1 costs, in nats: how much better it must predict."""

TOUCHING = 0.05
"""Boundary probability between two equal situations, since sensors and hands waver."""

ALONE = 8.0
"""Boundaries per unit of distance when a feature is judged alone."""

EQUAL = 0.1
"""What each feature is taken to predict beforehand, in nats per example."""


def _apart(a: Floats, b: Floats, scale: Scale) -> Floats:
    """Return the difference of each value of a, shape (k,), to each of b, shape (l,)."""
    difference = np.abs(a[:, None] - b[None, :])
    if scale.kind is FeatureKind.TOROIDAL:
        difference %= scale.period
        difference = np.minimum(difference, scale.period - difference)
    elif not scale.kind.is_measured:
        difference = np.where(np.isnan(difference), np.nan, (difference > 0).astype(np.float64))
    return difference


def distances(a: ArrayLike, b: ArrayLike, scales: Sequence[Scale], spread: Floats) -> Floats:
    """Return how far situations are apart in each feature, from 0 to 1.

    A difference d counts d / (d + spread), so that half is a usual difference and 1 an endless
    one; a feature that compares by equality counts 0 or 1. Where one value is missing the distance
    is one half, where both are, 0.

    Args:
        a, b: shapes (k, m) and (l, m), feature values.
        scales: how the values of each of the m features compare.
        spread: shape (m,), see `hitab_core.advice.spread`.

    Returns:
        shape (m, k, l).
    """
    A, B = np.asarray(a, np.float64), np.asarray(b, np.float64)
    found = np.zeros((len(scales), len(A), len(B)))
    for f, scale in enumerate(scales):
        apart = _apart(A[:, f], B[:, f], scale)
        if scale.kind.is_measured:
            apart = apart / (apart + spread[f])
        lacking = np.isnan(A[:, f])[:, None].astype(int) + np.isnan(B[:, f])[None, :]
        found[f] = np.where(lacking == 2, 0.0, np.where(lacking == 1, 0.5, apart))
    return found


@dataclass(frozen=True, slots=True, eq=False)
class Neighbors:
    """What the examples of one state say about one another.

    Attributes:
        labels: the k next states that occur.
        probabilities: shape (n, k), of each next state, by the other examples.
        mistaken: shape (n,), probability that an example's own next state is a mistake; 0 for a
            trusted one.
        apart: shape (n, n), how far they are apart, features weighed by how much they matter.
        share: estimated share of mistakes.
    """

    labels: tuple[str, ...]
    probabilities: Floats
    mistaken: Floats
    apart: Floats
    share: float


@dataclass(frozen=True, slots=True)
class _Setting:
    fall: float
    loudness: float
    sharpness: float

    def surprise(self, falls_usually: float) -> float:
        """Return what it costs, in nats, to depart from the usual setting."""
        return (
            0.5 * math.log(self.fall / falls_usually) ** 2
            + 0.5 * math.log(self.sharpness) ** 2
            + (LOUD if self.loudness > 1 else 0.0)
        )


def neighbors(apart: Floats, next_states: Sequence[str], trusted: Booleans) -> Neighbors:
    """Return what examples say about one another.

    Args:
        apart: shape (m, n, n), their distances in each feature, see `distances`.
        next_states: n labels.
        trusted: shape (n,), whether the person has just confirmed an example, as by correcting.
    """
    labels, own = np.unique(np.asarray(next_states), return_inverse=True)
    names = tuple(str(label) for label in labels)
    n, k = len(own), len(labels)
    if k < 2:
        return Neighbors(names, np.ones((n, k)), np.zeros(n), np.zeros((n, n)), 0.0)
    one_hot = np.eye(k)[own]
    usual = USUAL_FALL * math.sqrt(max(1, len(apart)))
    mean = np.tensordot(_weights(apart, one_hot), apart, axes=1)
    settings = [_Setting(usual * f, v, s) for f in FALLS for v in LOUDNESS for s in SHARPNESS]
    surprises = np.array([setting.surprise(usual) for setting in settings])
    votes_of = {(s.fall, s.loudness): _votes(mean, s) for s in settings}
    share, mistaken = MISTAKEN, np.zeros(n)
    for _ in range(ROUNDS):
        weights = one_hot * (1 - mistaken)[:, None]
        by_setting = np.array(
            [_probabilities(votes_of[s.fall, s.loudness], weights, s.sharpness) for s in settings]
        )
        fits = np.array([_log_likelihood(p, own, share) for p in by_setting]) - surprises
        likely = np.exp(fits - fits.max())
        probabilities = np.tensordot(likely / likely.sum(), by_setting, axes=1)
        mistaken = np.where(trusted, 0.0, _mistaken(probabilities, own, share))
        doubtful = int(np.count_nonzero(~trusted))
        share = (FIRM * MISTAKEN + float(mistaken.sum())) / (FIRM + doubtful)
    return Neighbors(names, probabilities, mistaken, mean, share)


def _weights(apart: Floats, one_hot: Floats) -> Floats:
    """Return the weight of each feature by what it predicts alone, shape (m,); their sum is 1."""
    n, k = one_hot.shape
    own = one_hot.argmax(axis=1)
    frequent = one_hot.mean(axis=0)
    blind = np.maximum(one_hot.sum(axis=0)[own] - 1, 0.5) / max(1, n - 1)
    gains = np.zeros(len(apart))
    for f, one in enumerate(apart):
        votes = np.exp(-ALONE * one)
        np.fill_diagonal(votes, 0.0)
        ballots = votes @ one_hot + 0.5 * frequent
        p = (ballots / ballots.sum(axis=1, keepdims=True))[np.arange(n), own]
        better = np.log((1 - MISTAKEN) * p + MISTAKEN / k).sum() - np.log(blind).sum()
        gains[f] = max(0.0, better - 1.0) / n  # a nat for having chosen it
    weights = gains + EQUAL
    return np.asarray(weights / weights.sum())


def _votes(apart: Floats, setting: _Setting) -> Floats:
    together = np.exp(-setting.fall * apart)
    votes = setting.loudness * together / (1 + TOUCHING - together)
    np.fill_diagonal(votes, 0.0)
    return votes


def _probabilities(votes: Floats, weights: Floats, sharpness: float) -> Floats:
    """Return the probability of each next state, shape (n, k), from weighted examples."""
    ballots = votes @ weights
    shares = (1 / weights.shape[1] + ballots) / (1 + ballots.sum(axis=1, keepdims=True))
    shares = shares**sharpness
    return np.asarray(np.maximum(shares / shares.sum(axis=1, keepdims=True), 1e-4))


def _log_likelihood(probabilities: Floats, own: Integers, share: float) -> float:
    p = probabilities[np.arange(len(own)), own]
    others = probabilities.shape[1] - 1
    return float(np.log((1 - share) * p + share * (1 - p) / others).sum())


def _mistaken(probabilities: Floats, own: Integers, share: float) -> Floats:
    """Return the posterior probability of a mistake: any other next state was meant."""
    p = probabilities[np.arange(len(own)), own]
    wrong = share * (1 - p) / (probabilities.shape[1] - 1)
    return np.asarray(wrong / (wrong + (1 - share) * p))
