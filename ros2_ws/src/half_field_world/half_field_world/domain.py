"""The domain ``half_field``: the keepers' words, and those that attackers need besides.

No behavior decides when it should be used. Speeds are in m/cycle.
"""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

from half_field_world.body import GOAL, SPOT, AttackerBody
from hitab_core import BasicBehavior, Domain, Feature, Target
from keepaway_world.behaviors import FAST, TURN_WHEN_OFF, go_by, pass_to, send_ball, stop, turn_to
from keepaway_world.body import NO_PLAYER
from keepaway_world.domain import DOMAIN as KEEPAWAY
from keepaway_world.features import NAN
from keepaway_world.game.angles import wrapped
from keepaway_world.game.interception import HORIZON, Interceptor
from keepaway_world.parameters import PAPER
from keepaway_world.percept import BALL

SHOT = PAPER.ball_speed_max
TOUCH = 1.1  # speed of the ball in a dribble: a runner reaches it again after five cycles
LOOKS_AHEAD = 5.0  # m
SIDESTEPS = tuple(math.radians(off) for off in (0.0, 35.0, -35.0, 70.0, -70.0))
PER_RAD = 2.0  # m of room that each rad of a turn away from the goal must gain
THERE = 1.0  # m: distance at which a place counts as reached

_RUNNER = Interceptor(PAPER)


def meet_ball(body: AttackerBody) -> None:
    """Run to where the ball can first be reached; stop it there."""
    if body.ball_is_kickable:
        stop(body)
        return
    (x, y), (vx, vy) = body.position, body.velocity
    (ball_x, ball_y), (ball_vx, ball_vy) = body.at(BALL), body.ball_velocity
    me: Any = SimpleNamespace(x=x, y=y, vx=vx, vy=vy, heading=body.heading)
    ball: Any = SimpleNamespace(x=ball_x, y=ball_y, vx=ball_vx, vy=ball_vy)
    track = _RUNNER.track(ball)
    cycles, _ = _RUNNER.intercept(me, track)
    to_x, to_y = track[min(cycles, HORIZON)]
    run(body, math.atan2(to_y - y - vy, to_x - x - vx))


def run(body: AttackerBody, bearing: float) -> None:
    """Turn to a bearing in the world's axes, or run if it is ahead."""
    off = wrapped(bearing - body.heading)
    if abs(off) > TURN_WHEN_OFF:
        body.turn_by(off)
    else:
        body.dash(FAST)


def run_to(body: AttackerBody, place: int) -> None:
    """Go to a place and rest there, facing the ball."""
    if place == NO_PLAYER:
        return
    (x, y), (to_x, to_y) = body.position, body.at(place)
    if math.hypot(to_x - x, to_y - y) > THERE:
        go_by(body, to_x - x, to_y - y)
    else:
        turn_to(body, BALL)


def shoot(body: AttackerBody) -> None:
    """Kick as hard as possible where the opponents miss the ball most widely."""
    if body.ball_is_kickable:
        send_ball(body, body.line_to(GOAL).bearing, SHOT)


def dribble(body: AttackerBody) -> None:
    """Run with the ball towards the goal, around opponents."""
    if not body.ball_is_kickable:
        meet_ball(body)
        return
    (x, y), (goal_x, goal_y) = body.at(BALL), body.at(GOAL)
    opponents = [body.at(taker) for taker in body.takers]
    ahead = math.atan2(goal_y - y, goal_x - x)

    def room(off: float) -> float:
        to = x + LOOKS_AHEAD * math.cos(ahead + off), y + LOOKS_AHEAD * math.sin(ahead + off)
        return min([LOOKS_AHEAD, *(math.dist(to, one) for one in opponents)]) - PER_RAD * abs(off)

    bearing = ahead + max(SIDESTEPS, key=room)
    off = wrapped(bearing - body.heading)
    if abs(off) <= 2.0 * TURN_WHEN_OFF:
        send_ball(body, bearing, TOUCH)
    elif math.hypot(*body.ball_velocity) > 0.2:
        stop(body)
    else:
        body.turn_by(off)


def line_slack(body: AttackerBody, place: int) -> float:
    """Return the distance by which opponents miss a pass to a mate or the best shot, m."""
    return NAN if place == NO_PLAYER else body.line_to(place).slack


BEHAVIORS = (
    BasicBehavior("MeetBall", meet_ball, description="run to where the ball can be reached first"),
    BasicBehavior("RunTo", run_to, parameters=("X",), description="go to X and face the ball"),
    BasicBehavior("Dribble", dribble, description="run with the ball towards the goal"),
    BasicBehavior("Shoot", shoot, one_shot=True, description="kick the ball at the goal, once"),
    BasicBehavior(
        "PassTo", pass_to, parameters=("X",), one_shot=True, description="pass to X and yell to it"
    ),
)

DOMAIN = Domain.of(
    "half_field",
    "1",
    AttackerBody,
    behaviors=(*KEEPAWAY.behaviors.values(), *BEHAVIORS),
    features=(
        *KEEPAWAY.features.values(),
        Feature(
            "RoomOnWayTo",
            line_slack,
            parameters=("X",),
            unit="m",
            description="distance by which opponents miss a ball kicked to X; < 0: they reach it",
        ),
    ),
    targets=(
        *KEEPAWAY.targets.values(),
        Target("goal", lambda body: GOAL, "the middle of the goal; for a shot, its open side"),
        Target("spot", lambda body: SPOT, "the penalty spot"),
        Target("near_wing", AttackerBody.near_wing, "beside the area, on the ball's side"),
        Target("far_wing", AttackerBody.far_wing, "beside the area, on the side without the ball"),
        Target("best_mate", AttackerBody.best_mate, "the mate to pass to: advanced, and in reach"),
    ),
    automata=KEEPAWAY.automata.values(),
)
