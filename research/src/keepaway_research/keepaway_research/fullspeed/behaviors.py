"""Basic behaviors for takers at full speed, in addition to `keepaway_research.predictive`.

Each gives at most one command per cycle. None decides when it should be used.
"""

from __future__ import annotations

import math

from hitab_core import BasicBehavior
from keepaway_research.fullspeed.body import FullSpeedBody
from keepaway_research.fullspeed.supporting import best_place
from keepaway_research.predictive.behaviors import kick
from keepaway_research.predictive.forecast import Point
from keepaway_world.behaviors import turn_to_ball
from keepaway_world.body import YELL
from keepaway_world.game.angles import wrapped
from keepaway_world.percept import BALL, HEIGHT, WIDTH

IN_TIME = 2  # cycles that a keeper wants to be before the ball
COMFORTABLE = 0.5  # m from the ball when they meet
EDGE = 0.4  # m from the edge of the box: the ball is met before
AT_PLACE = 0.8  # m: near enough to stand there
AT_BALL = 0.3  # m: likewise on the ball's way
FAR_OFF = math.radians(15.0)  # a keeper that is off by more turns
FAR_OFF_NEAR = math.radians(35.0)  # likewise for the last meter
STEP_BACK = 2.0  # m: a place behind the keeper and as near as this is reached backwards
HELD = 0.6  # m: largest distance of a stopped ball from the keeper's center


def meet_ball(body: FullSpeedBody) -> None:
    """Go to where the ball can be met with time to spare, or else with most time.

    Does nothing if the ball is kickable.
    """
    body.aim = None
    if body.ball_is_kickable:
        return
    half_width, half_height = body.values[WIDTH] / 2.0 - EDGE, body.values[HEIGHT] / 2.0 - EDGE
    track = body.ball_track
    best, most = track[-1], -math.inf
    for cycle in range(1, len(track)):
        place = track[cycle]
        if math.isfinite(most) and (abs(place[0]) > half_width or abs(place[1]) > half_height):
            break
        spare = cycle - _cycles_to(body, place)
        if spare > most:
            best, most = place, spare
            if spare >= IN_TIME:
                break
    _go_to(body, best, AT_BALL)


def _cycles_to(body: FullSpeedBody, place: Point) -> int:
    """Return the number of cycles until the keeper is at a place, with its turns."""
    (x, y), (vx, vy), out = body.position, body.velocity, body.tables.rolls_out
    dx, dy = place[0] - x - vx * out, place[1] - y - vy * out
    far = math.hypot(dx, dy) - COMFORTABLE
    if far <= 0.0:
        return 0
    off = wrapped(math.atan2(dy, dx) - body.heading)
    return body.tables.cycles_to_run(far) + body.turns(off)


def _go_to(body: FullSpeedBody, place: Point, near: float) -> None:
    """Come to rest at a place, backwards if it is close behind; then face the ball."""
    (x, y), (vx, vy), p = body.position, body.velocity, body.parameters
    out = body.tables.rolls_out
    dx, dy = place[0] - x, place[1] - y
    left_x, left_y = dx - vx * out, dy - vy * out
    if math.hypot(left_x, left_y) < near:
        turn_to_ball(body)
        return
    off = abs(wrapped(math.atan2(left_y, left_x) - body.heading))
    far = math.hypot(dx, dy)
    if off < FAR_OFF or (far < 1.0 and off < FAR_OFF_NEAR):
        way = far
    elif off > math.pi - FAR_OFF and far < STEP_BACK:
        way = -far
    else:
        body.turn_by(wrapped(math.atan2(left_y, left_x) - body.heading))
        return
    forward = vx * math.cos(body.heading) + vy * math.sin(body.heading)
    power = (way * (1.0 - p.player_decay) - forward) / p.dash_rate
    body.dash(min(max(power, -100.0), 100.0))


def stop_ball(body: FullSpeedBody) -> None:
    """Stop the ball within reach; does nothing if it is not kickable."""
    body.aim = None
    if not body.ball_is_kickable:
        return
    x, y = body.vector_to(BALL)
    (vx, vy), (own_vx, own_vy) = body.ball_velocity, body.velocity
    far = math.hypot(x, y)
    part = min(1.0, HELD / far) if far > 0.0 else 0.0
    kick(body, own_vx + x * part - x - vx, own_vy + y * part - y - vy)


def swift_pass_to(body: FullSpeedBody, mate: int) -> None:
    """Kick the ball to a teammate as fast as its lane needs, and yell its number.

    Does nothing if the ball is not kickable or there is no such mate.
    """
    body.aim = None
    if mate not in body.others or not body.ball_is_kickable:
        return
    lane = body.lane(mate)
    if lane.speed > 0.0:
        body.send_ball(lane)
        body.say(YELL.format(body.number_at(mate)))
        body.await_pass(body.number_at(mate))


def support(body: FullSpeedBody) -> None:
    """Stand where the ball can be passed to next, see `supporting`."""
    if not body.others:
        return
    body.aim = best_place(body)
    _go_to(body, body.aim, AT_PLACE)


BEHAVIORS = (
    BasicBehavior(
        "MeetBall",
        meet_ball,
        description="go to where the rolling ball can be met with time to spare",
    ),
    BasicBehavior("StopBall", stop_ball, description="stop the ball within reach and stand"),
    BasicBehavior(
        "SwiftPassTo",
        swift_pass_to,
        parameters=("X",),
        one_shot=True,
        description="kick the ball to X, as fast as the takers make it necessary, and yell to it",
    ),
    BasicBehavior(
        "Support",
        support,
        description="stand where the next pass can go when the takers have come near",
    ),
)
