"""Marking: a taker that is not needed at the ball stands in the way of a pass."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

from keepaway_research.reference.positioning import go_to, in_lane
from keepaway_research.reference.prediction import Motion, Predictor
from keepaway_research.reference.view import Seen
from keepaway_world.action import Order
from keepaway_world.game.angles import wrapped

AT_THE_BALL = 2
"""So many takers, those closest to the ball, go for it; any others mark."""

APART = 4.0  # m from a keeper that is marked, towards the ball
AHEAD = 1.0  # m towards the takers' own goal: where a keeper is expected to be soon
ARRIVED = 2.0  # m
ASIDE = math.radians(80.0)  # to the ball's side of the keeper: where a taker looks that is there
TURN_WHEN_OFF = math.radians(25.0)
BACK = 3.0  # m, from where on it goes backwards rather than turn


def most_open(passer: Seen, keepers: Sequence[Seen], takers: Sequence[Seen]) -> Seen:
    """Return the keeper with the fewest takers in its lane from the passer; of equals the last.

    No taker can be in the lane of the passer to itself, so that it may be marked, too.
    """
    start = complex(passer.x, passer.y)

    def in_the_way(keeper: Seen) -> int:
        end = complex(keeper.x, keeper.y)
        return sum(in_lane(start, end, complex(taker.x, taker.y)) for taker in takers)

    return min(reversed(keepers), key=in_the_way)


def mark(predictor: Predictor, me: Seen, keeper: Seen, ball: Seen, forward: float) -> Order:
    """Return the command of a taker that marks a keeper.

    Args:
        predictor: of motion.
        me: the taker.
        keeper: whom it marks.
        ball: from where a pass may come.
        forward: 1 if the takers play towards +x, -1 if towards -x.
    """
    motion = Motion.of(me)
    origin, at = complex(ball.x, ball.y), complex(keeper.x, keeper.y)
    expected = at - AHEAD * forward
    place = expected + cmath.rect(APART, cmath.phase(origin - expected))
    if abs(motion.position - place) >= ARRIVED:
        return go_to(predictor, motion, place, TURN_WHEN_OFF, BACK)
    to_keeper = cmath.phase(at - motion.position)
    aside = wrapped(cmath.phase(origin - motion.position) - to_keeper)
    looks = to_keeper + math.copysign(ASIDE, aside)
    return predictor.turn_to(motion, motion.position + cmath.rect(1.0, looks))
