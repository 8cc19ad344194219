"""Getting open for a pass, and going to a place."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

from keepaway_research.reference.prediction import Motion, Predictor, bearing
from keepaway_research.reference.view import Seen
from keepaway_world.action import Order
from keepaway_world.game.angles import PI, wrapped

GRID = 5  # by 5 points
INSET = 0.15  # of the box, on each side
CONE = 0.3  # half-width of a lane, as a part of the distance from the ball
ARRIVED = 1.5  # m
TURN_WHEN_OFF = math.radians(7.0)
TURNS_AT_ONCE = 2  # a player that needs more turns than this stops first


def open_point(
    size: tuple[float, float],
    ball: complex,
    others: Sequence[complex],
    opponents: Sequence[complex],
) -> complex:
    """Return the least congested grid point that a pass can reach, or the center.

    Args:
        size: of the box, m.
        ball: origin of the pass.
        others: the other players, including opponents.
        opponents: which must not stand in the lane from the ball to the point.
    """
    best, least = 0j, math.inf
    steps = [(i / (GRID - 1) - 0.5) * (1.0 - 2.0 * INSET) for i in range(GRID)]
    for across in steps:
        for along in steps:
            point = complex(across * size[0], along * size[1])
            congestion = sum(1.0 / max(abs(other - point), 1e-9) for other in others)
            if congestion < least and not any(in_lane(ball, point, o) for o in opponents):
                best, least = point, congestion
    return best


def in_lane(start: complex, end: complex, player: complex) -> bool:
    """Whether a player stands in the cone from ``start`` to ``end``."""
    length = abs(end - start)
    if length == 0.0:
        return False
    relative = (player - start) * ((end - start).conjugate() / length)
    along, aside = relative.real, abs(relative.imag)
    return aside < CONE * abs(along) and 0.0 < along < length and abs(player - start) < length


def get_open(predictor: Predictor, me: Seen, point: complex, ball: complex) -> Order:
    """Return the command that moves a player to its open point, or turns it to the ball."""
    motion = Motion.of(me)
    if abs(motion.position - point) < ARRIVED:
        return predictor.turn_to(motion, ball)
    return go_to(predictor, motion, point, TURN_WHEN_OFF)


def go_to(
    predictor: Predictor, motion: Motion, point: complex, off_most: float, back: float = 0.0
) -> Order:
    """Return the command that moves a player to a point, if it need not be there in time.

    Args:
        predictor: of motion.
        motion: of the player.
        point: to go to.
        off_most: rad, by how much its heading may be off before it turns.
        back: m, from where on it goes there backwards rather than turn.
    """
    decay = predictor.parameters.player_decay
    final = motion.position + motion.velocity / (1.0 - decay)
    off = bearing(motion, point - final)
    backwards = abs(wrapped(off + PI)) < off_most and abs(motion.position - point) < back
    if abs(off) < off_most or backwards:
        return predictor.dash_to(motion, point)
    wanted = cmath.phase(point - final)
    turning, turns = motion.copy(), 0
    while abs(off) > off_most and turns <= TURNS_AT_ONCE:
        predictor.turned(turning, predictor.moment(off, abs(turning.velocity)))
        off = wrapped(wanted - turning.heading)
        turns += 1
    if turns <= TURNS_AT_ONCE:
        return predictor.turn_to(motion, point, 2)
    return predictor.dash_to(motion, motion.position)
