"""The features of many keepers at once, with exactly the values that each reads alone.

All percepts must come from games with the same numbers of players. Rows are keepers.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from hitab_core import BatchPercepts, Domain
from hitab_core.arrays import Floats, Integers
from keepaway_world import percept
from keepaway_world.body import NOBODY, YELL
from keepaway_world.domain import DOMAIN as KEEPAWAY
from keepaway_world.parameters import PAPER
from keepaway_world.percept import BALL, OTHERS

_DOUBTFUL = 1e-9  # m: numpy's cosine may differ from math's, but only in the last bit


def ball_of_all(percepts: BatchPercepts) -> Integers:
    """Return the place of the ball in each percept."""
    return np.full(len(percepts.values), BALL)


def closest_keeper_of_all(percepts: BatchPercepts) -> Integers:
    """Return the place of the closest other keeper of each keeper, or `NOBODY`."""
    return _closest(percepts.values, OTHERS, _first_taker(percepts))


def closest_taker_of_all(percepts: BatchPercepts) -> Integers:
    """Return the place of the closest taker of each keeper, or `NOBODY`."""
    return _closest(percepts.values, _first_taker(percepts), percepts.values.shape[1])


def _first_taker(percepts: BatchPercepts) -> int:
    keepers = int(percepts.values[0, percept.KEEPERS]) if len(percepts.values) else 1
    return OTHERS + 2 * (keepers - 1)


def _closest(values: Floats, first: int, end: int) -> Integers:
    if first == end:
        return np.full(len(values), NOBODY)
    return first + 2 * values[:, first:end:2].argmin(axis=1)


def distance_to_all(percepts: BatchPercepts, places: Integers) -> Floats:
    """Return each keeper's distance to the player or ball at its place, m; NaN for `NOBODY`."""
    return _at(percepts.values, places, 0)


def direction_to_all(percepts: BatchPercepts, places: Integers) -> Floats:
    """Return each keeper's direction to the player or ball at its place, rad; NaN for `NOBODY`."""
    return _at(percepts.values, places, 1)


def _at(values: Floats, places: Integers, offset: int) -> Floats:
    there = places != NOBODY
    found: Floats = values[np.arange(len(values)), np.where(there, places + offset, 0)]
    found[~there] = np.nan
    return found


def all_yelled_at(percepts: BatchPercepts) -> Floats:
    """Whether a passer's yell to each keeper was heard in this cycle."""
    yelled_at = np.zeros(len(percepts.values))
    for row, heard in percepts.heard.items():
        number = int(percepts.values[row, percept.NUMBER])
        yelled_at[row] = YELL.format(number) in heard
    return yelled_at


def ball_is_kickable_for_all(percepts: BatchPercepts) -> Floats:
    """Whether the ball is within each keeper's kicking range, as far as it can see."""
    return (percepts.values[:, BALL] <= PAPER.kickable).astype(np.float64)


def teammates_closer_to_ball_of_all(percepts: BatchPercepts) -> Floats:
    """Whether another keeper is closer to the ball than each keeper, as far as it can see."""
    values, end = percepts.values, _first_taker(percepts)
    own, bearing = values[:, BALL, None], values[:, BALL + 1, None]
    away, directions = values[:, OTHERS:end:2], values[:, OTHERS + 1 : end : 2]
    reach = 2.0 * own * np.cos(directions - bearing)
    closer = away < reach
    for row, other in np.argwhere(np.abs(away - reach) < _DOUBTFUL).tolist():
        exact = 2.0 * float(own[row, 0]) * math.cos(directions[row, other] - bearing[row, 0])
        closer[row, other] = away[row, other] < exact
    return np.asarray(closer.any(axis=1), np.float64)


_READ: dict[str, Callable[..., Floats]] = {
    "DistanceTo": distance_to_all,
    "DirectionTo": direction_to_all,
    "IWasYelledAt": all_yelled_at,
    "BallIsKickable": ball_is_kickable_for_all,
    "ATeammateIsCloserToBall": teammates_closer_to_ball_of_all,
}
_RESOLVED = {
    "ball": ball_of_all,
    "closest_keeper": closest_keeper_of_all,
    "closest_taker": closest_taker_of_all,
}

DOMAIN = Domain.of(
    KEEPAWAY.name,
    KEEPAWAY.version,
    KEEPAWAY.body,
    behaviors=KEEPAWAY.behaviors.values(),
    features=[replace(f, read_all=_READ[f.name]) for f in KEEPAWAY.features.values()],
    targets=[replace(t, resolve_all=_RESOLVED.get(t.name)) for t in KEEPAWAY.targets.values()],
    automata=KEEPAWAY.automata.values(),
)
"""The domain keepaway with features that are read for all at once."""
