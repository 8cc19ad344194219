"""Policies for a keeper with the ball: hand-coded, random, or always hold."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from random import Random

from keepaway_research.reference.view import Seen, View
from keepaway_world.game.angles import wrapped

HOLD = 0
SAFE = 5.0  # m: safe if no taker is nearer
HOLD_SCORE = 90.0
PER_METER = 4.0  # degrees per meter of distance from the nearest taker

Policy = Callable[[View, Random], int]
"""Returns `HOLD` or i > 0 for a pass to the i-th closest teammate."""


def by_distance(players: Sequence[Seen], origin: Seen) -> list[Seen]:
    """Return the players by their distance from ``origin``, which comes first."""
    return sorted(players, key=lambda k: math.hypot(k.x - origin.x, k.y - origin.y))


def hand(view: View, random: Random) -> int:
    """Hold while no taker is near, else choose the best score (Stone, Sutton, Kuhlmann 2005)."""
    ball = view.ball
    passer = min(view.keepers, key=lambda k: math.hypot(k.x - ball.x, k.y - ball.y))
    if not view.takers:
        return HOLD
    if min(math.hypot(t.x - passer.x, t.y - passer.y) for t in view.takers) > SAFE:
        return HOLD
    best, most = HOLD, HOLD_SCORE
    for number, mate in enumerate(by_distance(view.keepers, passer)):
        if number == 0:
            continue
        open_by = min(math.hypot(t.x - mate.x, t.y - mate.y) for t in view.takers)
        angle = min(_angle(passer, mate, taker) for taker in view.takers)
        score = PER_METER * open_by + math.degrees(angle)
        if score > most:
            best, most = number, score
    return best


def _angle(at: Seen, one: Seen, other: Seen) -> float:
    """Return the angle at a player between two others."""
    first = cmath.phase(complex(one.x - at.x, one.y - at.y))
    second = cmath.phase(complex(other.x - at.x, other.y - at.y))
    return abs(wrapped(first - second))


def rand(view: View, random: Random) -> int:
    """Hold, or pass to any teammate, with equal chance."""
    return random.randrange(len(view.keepers))


def hold(view: View, random: Random) -> int:
    """Never pass."""
    return HOLD
