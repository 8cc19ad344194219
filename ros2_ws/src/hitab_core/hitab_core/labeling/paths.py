"""Sequences of states: the state of each moment, given the likelihood of its action in each state.

A run has n moments and k states. ``steps[t, i, j]`` is the probability that state i is followed by
j at moment t, which depends on the features seen there; ``odds[t, j]`` is proportional to how
likely the action at moment t is in state j. All is for one run.
"""

from __future__ import annotations

import numpy as np

from hitab_core.numeric.arrays import Floats, Integers


def forward(start: Floats, steps: Floats, odds: Floats) -> Floats:
    """Return the probability of each state at each moment given all until then, shape (n, k).

    Args:
        start: shape (k,), of the states before the first moment.
        steps: shape (n, k, k), rows sum to 1.
        odds: shape (n, k); equal in a row if the action is unknown.
    """
    found = np.empty(steps.shape[:2])
    now = start
    for t, step in enumerate(steps):
        now = (now @ step) * odds[t]
        now = now / now.sum()
        found[t] = now
    return found


def posterior(forward: Floats, steps: Floats) -> Floats:
    """Return the probability of each state at each moment given the whole run, shape (n, k)."""
    found = forward.copy()
    for t in range(len(forward) - 2, -1, -1):
        reached = forward[t] @ steps[t + 1]
        ratio = np.divide(found[t + 1], reached, out=np.zeros_like(reached), where=reached > 0)
        found[t] = forward[t] * (steps[t + 1] @ ratio)
        found[t] /= found[t].sum()
    return found


def draw(forward: Floats, steps: Floats, n: int, rng: np.random.Generator) -> Integers:
    """Return sequences drawn given the whole run, shape (n, number of moments)."""
    drawn = np.empty((n, len(forward)), np.int64)
    odds = np.broadcast_to(forward[-1], (n, forward.shape[1]))
    for t in range(len(forward) - 1, -1, -1):
        if t < len(forward) - 1:
            odds = forward[t] * steps[t + 1][:, drawn[:, t + 1]].T
        reached = np.cumsum(odds, axis=1)
        drawn[:, t] = (rng.random((n, 1)) * reached[:, -1:] >= reached).sum(axis=1)
    return drawn
