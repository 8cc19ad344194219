"""A keeper's percept: a flat list of floats for any number of players.

====================  =====================================================================
index                 value
====================  =====================================================================
0                     own number, from 1
1, 2                  number of keepers n, number of takers m
3, 4                  width and height of the box, m
5, 6, 7               own position, m, and heading, rad; exact: the keeper is localised
8, 9                  own velocity, m/s; exact
10, 11                ball: distance, m, and direction relative to the body, rad
12, 13                ball: velocity, m/s, in the world's axes
14, 15 and so on      the n - 1 other keepers, by rising number: distance and direction
14 + 2(n - 1) on      the m takers: distance and direction
====================  =====================================================================

Everything seen of others is quantised (see `keepaway_world.game.sight`) unless sight is "full".
x points right, y up, angles are counter-clockwise.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from keepaway_world.game.angles import PI
from keepaway_world.game.sight import quantised_direction, quantised_distance, seen_velocity

if TYPE_CHECKING:  # an agent needs the layout, not pymunk
    from keepaway_world.game.physics import Mover, Physics

NUMBER, KEEPERS, TAKERS, WIDTH, HEIGHT = range(5)
X, Y, HEADING, VX, VY = range(5, 10)
BALL = 10
BALL_VX, BALL_VY = 12, 13
OTHER_PLAYERS = 14
CYCLES_PER_SECOND = 10.0


def percept_length(keepers: int, takers: int) -> int:
    """Return the number of values in a percept."""
    return OTHER_PLAYERS + 2 * (keepers - 1 + takers)


def perceive(physics: Physics, keeper: Mover) -> list[float]:
    """Return the current percept of ``keeper``, in the layout above."""
    p = physics.parameters
    full = p.sight == "full"
    x, y, heading = keeper.x, keeper.y, keeper.heading
    ball = physics.ball
    dx, dy = ball.x - x, ball.y - y
    distance = math.hypot(dx, dy)
    direction = _relative(dx, dy, heading)
    vx, vy = ball.vx, ball.vy
    if not full:
        distance = quantised_distance(distance)
        direction = quantised_direction(direction)
        vx, vy = seen_velocity(
            dx, dy, vx - keeper.vx, vy - keeper.vy, distance, heading + direction
        )
        vx += keeper.vx
        vy += keeper.vy
    values = [
        float(keeper.index),
        float(p.keepers),
        float(p.takers),
        p.width,
        p.height,
        x,
        y,
        heading,
        keeper.vx * CYCLES_PER_SECOND,
        keeper.vy * CYCLES_PER_SECOND,
        distance,
        direction,
        vx * CYCLES_PER_SECOND,
        vy * CYCLES_PER_SECOND,
    ]
    append = values.append
    for other in physics.players:
        if other is not keeper:
            dx, dy = other.x - x, other.y - y
            distance = math.hypot(dx, dy)
            direction = _relative(dx, dy, heading)
            append(distance if full else quantised_distance(distance))
            append(direction if full else quantised_direction(direction))
    return values


def _relative(dx: float, dy: float, heading: float) -> float:
    """Return the direction of (dx, dy) relative to ``heading``, on [-pi, pi]."""
    direction = math.atan2(dy, dx) - heading
    if direction > PI:
        return direction - 2.0 * PI
    if direction < -PI:
        return direction + 2.0 * PI
    return direction
