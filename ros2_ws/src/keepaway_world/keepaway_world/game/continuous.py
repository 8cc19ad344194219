"""The domain ``keepaway_continuous``: hand-coded keepers that also take numbers.

A direction to run or to kick is shown with the command, and learned as a function of features. The
words are those of ``keepaway_handcoded`` and some that such functions need.
"""

from __future__ import annotations

import math

from hitab_core import BasicBehavior, BoundedNumber, Domain, Feature, FeatureKind, Target
from keepaway_world.behaviors import FAST, TURN_WHEN_OFF
from keepaway_world.body import NO_PLAYER, KeeperBody
from keepaway_world.features import NAN, direction_to
from keepaway_world.game.angles import wrapped
from keepaway_world.hand_coded_team import DOMAIN as HAND_CODED
from keepaway_world.percept import BALL, CYCLES_PER_SECOND

DIRECTION = BoundedNumber("direction", -180.0, 180.0, "deg", circular=True)
POWER = BoundedNumber("power", 0.0, 100.0)


def run_towards(body: KeeperBody, direction: float) -> None:
    """Run with full power ``direction`` degrees counter-clockwise of the body; turn first."""
    off = wrapped(math.radians(direction))
    if abs(off) > TURN_WHEN_OFF:
        body.turn_by(off)
    else:
        body.dash(FAST)


def run_beside(body: KeeperBody, place: int, direction: float) -> None:
    """Run ``direction`` degrees counter-clockwise of where X is; do nothing without an X."""
    bearing = direction_to(body, place)
    if not math.isnan(bearing):
        run_towards(body, math.degrees(bearing) + direction)


def kick(body: KeeperBody, power: float, direction: float) -> None:
    """Kick the ball ``direction`` degrees counter-clockwise of the body, if it is kickable."""
    if body.ball_is_kickable:
        body.kick(power, math.radians(direction))


def ball_speed(body: KeeperBody) -> float:
    """Return the ball's speed, m/s."""
    return math.hypot(*body.ball_velocity) * CYCLES_PER_SECOND


def ball_course(body: KeeperBody) -> float:
    """Return the ball's course relative to the direction to it, rad; pi: it comes straight."""
    vx, vy = body.ball_velocity
    if vx == vy == 0.0:
        return NAN
    bearing = body.heading + body.values[BALL + 1]
    return wrapped(math.atan2(vy, vx) - bearing)


def _farthest_keeper(body: KeeperBody) -> int:
    return max(body.others, key=body.values.__getitem__, default=NO_PLAYER)


DOMAIN = Domain.of(
    "keepaway_continuous",
    "1",
    KeeperBody,
    behaviors=(
        *HAND_CODED.behaviors.values(),
        BasicBehavior(
            "RunTowards", run_towards, numbers=(DIRECTION,), description="run in a direction"
        ),
        BasicBehavior(
            "RunBeside",
            run_beside,
            parameters=("X",),
            numbers=(DIRECTION,),
            description="run in a direction relative to where X is",
        ),
        BasicBehavior(
            "Kick",
            kick,
            one_shot=True,
            numbers=(POWER, DIRECTION),
            description="kick the ball in a direction",
        ),
    ),
    features=(
        *HAND_CODED.features.values(),
        Feature("BallSpeed", ball_speed, unit="m/s", description="speed of the ball"),
        Feature(
            "BallCourse",
            ball_course,
            FeatureKind.TOROIDAL,
            unit="rad",
            description="where the ball rolls, relative to the direction to it",
        ),
    ),
    targets=(
        *HAND_CODED.targets.values(),
        Target("farthest_keeper", _farthest_keeper, "the farthest other keeper"),
    ),
    automata=HAND_CODED.automata.values(),
)
