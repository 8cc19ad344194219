"""Where a keeper without the ball should stand, so that it can be passed to next.

The takers run for the ball. So what counts is not the lane as it is, but as it will be when they
have come near and the pass is due.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

from keepaway_research.fullspeed.body import FullSpeedBody
from keepaway_research.fullspeed.passing import Tables
from keepaway_research.predictive.forecast import Point
from keepaway_world.percept import HEIGHT, WIDTH

PLACES = 6  # along either side of the box
INSET = 2.5  # m from the edge of the box to the outermost places
PRESSED = 5.0  # m from the ball to a taker when the ball is passed
TYPICAL = 2.0  # m/cycle of a pass
CLOSE = 4.0  # m: a mate this near to the ball is of no use
USELESS = 50.0  # m of slack
ENOUGH = 2.0  # m of slack
LONG = 12.0  # m: a longer pass gives no more time
APART = 10.0  # m from the other free keeper
SPREAD = 1.6  # rad between the two lanes
ROUNDING = 1e-9  # m of slack: more than what rounding can add up to
# What these are worth, in m of slack:
PER_M_OF_PASS, PER_M_APART, PER_RAD, PER_M_OF_WAY, STAYING = 0.15, 0.2, 0.3, 0.12, 1.0


def best_place(body: FullSpeedBody) -> Point:
    """Return where to stand: the most valuable of a grid of places.

    The place it has is worth more, so that a keeper stands still when the ball comes. Lanes, which
    take the most time, are only judged of places that could still be the best.
    """
    track = body.ball_track
    mates = {mate: body.place_of(mate) for mate in body.others}
    when = {mate: body.cycles_to_meet(place) for mate, place in mates.items()}
    holder = min(when, key=lambda mate: when[mate])
    ball = track[min(when[holder], len(track) - 1)]
    others = [place for mate, place in mates.items() if mate != holder]
    takers = [_pressing(body.place_of(taker), ball) for taker in body.takers]
    here, aim = body.position, body.aim
    grid: Sequence[Point] = places(body.values[WIDTH], body.values[HEIGHT])
    best, most = here, -math.inf
    ceiling = PER_M_OF_PASS * LONG + PER_M_APART * APART + PER_RAD * SPREAD * len(others)
    ceiling += ENOUGH + ROUNDING
    for place in grid if aim is None else (aim, *grid):
        way = PER_M_OF_WAY * math.dist(place, here)
        if place == aim:
            value = _worth_without_lane(place, ball, others) - way + STAYING
        elif ceiling <= most + way or _is_worth_less(most + way - ceiling, place, ball, others):
            continue
        else:
            value = _worth_without_lane(place, ball, others) - way
        if value + ENOUGH > most:
            value += _slack_of_place(body.tables, place, ball, takers)
            if value > most:
                best, most = place, value
    return best


@lru_cache(maxsize=16)
def places(width: float, height: float) -> tuple[Point, ...]:
    """Return the grid of places in a box."""
    steps = [2.0 * step / (PLACES - 1) - 1.0 for step in range(PLACES)]
    return tuple(
        (a * (width / 2.0 - INSET), b * (height / 2.0 - INSET)) for a in steps for b in steps
    )


def _pressing(taker: Point, ball: Point) -> Point:
    """Return where a taker is when it has come near to the ball."""
    dx, dy = taker[0] - ball[0], taker[1] - ball[1]
    away = math.hypot(dx, dy)
    part = min(1.0, PRESSED / away) if away > 0.0 else 0.0
    return ball[0] + dx * part, ball[1] + dy * part


def _is_worth_less(than: float, place: Point, ball: Point, others: Sequence[Point]) -> bool:
    """Whether its distances make a place worth less than ``than``; the best are worth 0."""
    lacking = math.dist(place, ball) - LONG
    worth = PER_M_OF_PASS * lacking if lacking < 0.0 else 0.0
    if worth <= than:
        return True
    for other in others:
        lacking = math.dist(place, other) - APART
        if lacking < 0.0 and worth + PER_M_APART * lacking <= than:
            return True
    return False


def _worth_without_lane(place: Point, ball: Point, others: Sequence[Point]) -> float:
    """Return what the distances and directions of a place are worth, in m of slack."""
    dx, dy = place[0] - ball[0], place[1] - ball[1]
    far = math.hypot(dx, dy)
    if far < CLOSE:
        return far - USELESS
    value = PER_M_OF_PASS * min(far, LONG)
    value += PER_M_APART * min([APART, *(math.dist(place, other) for other in others)])
    for x, y in others:
        x, y = x - ball[0], y - ball[1]
        off = abs(math.atan2(dx * y - dy * x, dx * x + dy * y))
        value += PER_RAD * min(off, SPREAD)
    return value


def _slack_of_place(tables: Tables, place: Point, ball: Point, takers: Sequence[Point]) -> float:
    """Return by how much takers miss a typical pass to a place, m; at most `ENOUGH`."""
    dx, dy = place[0] - ball[0], place[1] - ball[1]
    far = math.hypot(dx, dy)
    if far < CLOSE:
        return 0.0
    ux, uy = dx / far, dy / far
    slack = ENOUGH
    for x, y in takers:
        x, y = x - ball[0], y - ball[1]
        along, across = x * ux + y * uy, x * uy - y * ux
        part = 0.0 if along < 0.0 else far if along > far else along
        away = math.hypot(across, along - part)
        late = tables.time_to_roll(part, TYPICAL) - 1.0
        misses = away - (late if late > 0.0 else 0.0) - tables.kickable
        if misses < slack:
            slack = misses
    return slack
