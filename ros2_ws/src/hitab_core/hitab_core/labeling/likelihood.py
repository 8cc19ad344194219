"""Likelihood of an action under each basic behavior: a bell around its own action."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from hitab_core.domain import FeatureKind, Scale
from hitab_core.numeric.arrays import Booleans, Floats, Integers

SURE = 4.0
"""Spreads; a moment farther from all behaviors is explained by none."""

_FLOOR = 1e-3
"""The least spread, as a share of the largest difference: exact scripts have none."""

_EXACT = 0.02
"""Share of the time, for each of two behaviors, in which a program's actions equal theirs exactly.

Then no behavior explains the program's other actions. People hit only rest exactly.
"""

_EQUAL = 1e-6
"""A share of the least spread; numbers that are closer are equal."""

_NEAR, _OF_A_BELL = 0.95, 1.148
"""A share of moments, and the factor from their root mean square to a standard deviation."""

_BEYOND = -0.5 * SURE**2 - 4
"""Log likelihood, relative to a behavior's own action, of any other action; bounds outliers."""


def apart(did: ArrayLike, would: ArrayLike, scales: Sequence[Scale] | None = None) -> Floats:
    """Return the distance of the actions from each behavior's output, shape (n, k, d).

    Args:
        did: shape (n, d); NaN where not measured.
        would: shape (n, k, d): the output of each behavior; NaN where it leaves it open.
        scales: scales of the d numbers; a toroidal one wraps around. None if none does.
    """
    found = np.asarray(did, np.float64)[:, None, :] - np.asarray(would, np.float64)
    for i, scale in enumerate(scales or ()):
        if scale.kind is FeatureKind.TOROIDAL:
            half = scale.period / 2
            found[..., i] = (found[..., i] + half) % scale.period - half
    return found


def spread_of(apart: Floats, labels: Integers | None = None) -> Floats:
    """Return the usual distance of actions from their behavior's output, shape (d,).

    It is one standard deviation of a bell, by the nearest 95 % of the moments, so that a few
    unexplained ones do not widen it; the least, if the driver was a program (`_EXACT`).

    Args:
        apart: shape (n, k, d).
        labels: shape (n,), which behavior each moment was; None for the nearest, which makes the
            spread too small if behaviors are closer together than it.
    """
    size = np.nan_to_num(np.abs(apart))
    least = np.maximum(_FLOOR * size.max(axis=(0, 1)), 1e-9)
    if labels is None:
        labels = (size / np.maximum(size.mean(axis=(0, 1)), 1e-9)).sum(axis=2).argmin(axis=1)
    own = size[np.arange(len(size)), labels]
    exact = (own <= _EQUAL * least).all(axis=1)
    if np.sort(np.bincount(labels[exact], minlength=2))[-2] >= _EXACT * len(own):
        return np.asarray(least)
    own = np.sort(own, axis=0)
    near = own[: int(np.ceil(_NEAR * len(own)))]
    return np.asarray(np.maximum(_OF_A_BELL * np.sqrt((near**2).mean(axis=0)), least))


def log_likelihoods(apart: Floats, spread: Floats) -> Floats:
    """Return the log likelihood of each behavior at each moment, up to a constant, shape (n, k).

    A number that is NaN says nothing.
    """
    far = -0.5 * np.nansum((apart / spread) ** 2, axis=2)
    return np.asarray(np.logaddexp(far, _BEYOND))


def unexplained(apart: Floats, spread: Floats) -> Booleans:
    """Return whether no behavior explains the action, by moment, shape (n,)."""
    worst = np.nan_to_num(np.abs(apart) / spread).max(axis=2)
    return np.asarray(worst.min(axis=1) > SURE)
