"""Basic behaviors that look ahead, in addition to `keepaway_world.behaviors`.

Like those, each gives at most one command per cycle, decides from the current percept alone and
keeps no state. Powers are those of rcssserver, 0 to 100; speeds are in m/cycle.
"""

from __future__ import annotations

import math

from hitab_core import BasicBehavior
from keepaway_research.predictive.body import PredictiveBody
from keepaway_research.predictive.forecast import Point
from keepaway_research.predictive.lanes import clearance
from keepaway_world import percept
from keepaway_world.behaviors import go_by, pass_to, turn_to_ball
from keepaway_world.body import NO_PLAYER
from keepaway_world.game.angles import wrapped
from keepaway_world.game.kicking import kick_power
from keepaway_world.percept import BALL

THERE = 0.5  # m: a place closer than this is not worth going to

STILL = 0.05  # m/cycle²: a kick weaker than this is not worth its noise

SHIELD = 0.6  # m: distance of a shielded ball from the keeper's center
SHIELD_FROM = 6.0  # m: a taker farther away is no danger, and the ball is only stopped

RINGS = (0.35, 0.6, 0.8)  # of half the box: radii of OfferPass's rings of points
SPOKES = 12  # points in each
LANE_ENOUGH = 4.0  # m: a lane with this clearance is as good as any
APART = 9.0  # m: a larger distance from teammates and takers is no better


def go_to(body: PredictiveBody, place: Point) -> None:
    """Turn or dash towards a place to come to rest there; at the place, face the ball."""
    x, y = body.position
    dx, dy = place[0] - x, place[1] - y
    vx, vy = body.velocity
    rolls_out = 1.0 / (1.0 - body.parameters.player_decay)
    if math.hypot(dx - vx * rolls_out, dy - vy * rolls_out) < THERE:
        turn_to_ball(body)
    else:
        go_by(body, dx, dy)


def intercept_ball(body: PredictiveBody) -> None:
    """Go to where the ball can first be met; do nothing if it is within kicking range."""
    if not body.ball_is_kickable:
        go_to(body, body.meeting.place)


def hold_ball(body: PredictiveBody) -> None:
    """Keep the ball beside the keeper, on the side away from the closest taker.

    The keeper does not go anywhere. Does nothing if the ball is not kickable.
    """
    if not body.ball_is_kickable:
        return
    taker = body.closest_taker()
    x, y = body.vector_to(BALL)
    vx, vy = body.ball_velocity
    # Wanted position of the ball in the next cycle, relative to the keeper's current one.
    own_vx, own_vy = body.velocity
    if taker == NO_PLAYER or body.values[taker] > SHIELD_FROM:
        distance = math.hypot(x, y)
        scale = min(1.0, SHIELD / distance) if distance > 0.0 else 0.0
        to_x, to_y = own_vx + x * scale, own_vy + y * scale
    else:
        taker_x, taker_y = body.vector_to(taker)
        far = math.hypot(taker_x, taker_y)
        to_x = own_vx - SHIELD * taker_x / far
        to_y = own_vy - SHIELD * taker_y / far
    ax, ay = to_x - x - vx, to_y - y - vy
    kick(body, ax, ay)


def kick(body: PredictiveBody, ax: float, ay: float) -> None:
    """Accelerate the ball by this much, m/cycle², or as much as possible in that direction."""
    wanted = math.hypot(ax, ay)
    if wanted > STILL:
        power = kick_power(body.parameters, wanted, body.values[BALL], body.values[BALL + 1])
        body.kick(min(power, 100.0), wrapped(math.atan2(ay, ax) - body.heading))


def offer_pass(body: PredictiveBody) -> None:
    """Go to where a pass from the ball would be safe, away from all others.

    The target is a point on one of three rings around the center: it should have a clear lane from
    the ball's future position, be far from takers and teammates, and be close to the keeper.
    """
    x, y = body.position
    mates = [body.place_of(place) for place in body.others]
    takers = [body.place_of(place) for place in body.takers]
    ball = body.ball_track[min(len(body.ball_track) - 1, body.soonest_mate())]
    best, most = (x, y), -math.inf
    for point in open_points(body):
        value = (
            2.0 * min(clearance(ball, point, takers), LANE_ENOUGH)
            + min([APART, *(math.dist(point, mate) for mate in mates)])
            + min([APART, *(math.dist(point, taker) for taker in takers)])
            - 0.3 * math.dist(point, (x, y))
        )
        if value > most:
            best, most = point, value
    go_to(body, best)


def open_points(body: PredictiveBody) -> list[Point]:
    """Return the points that OfferPass chooses from."""
    half = min(body.values[percept.WIDTH], body.values[percept.HEIGHT]) / 2.0
    return [
        (
            half * ring * math.cos(2.0 * math.pi * spoke / SPOKES),
            half * ring * math.sin(2.0 * math.pi * spoke / SPOKES),
        )
        for ring in RINGS
        for spoke in range(SPOKES)
    ]


BEHAVIORS = (
    BasicBehavior(
        "InterceptBall",
        intercept_ball,
        description="go to where the rolling ball can first be met",
    ),
    BasicBehavior(
        "HoldBall",
        hold_ball,
        description="keep the ball at the foot, on the side away from the closest taker",
    ),
    BasicBehavior(
        "PassTo",
        pass_to,
        parameters=("X",),
        one_shot=True,
        description="kick the ball to X and yell to it",
    ),
    BasicBehavior(
        "OfferPass",
        offer_pass,
        description="go to where a pass would be safe, away from everybody else",
    ),
)
