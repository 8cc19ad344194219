"""The keepers' basic behaviors (the paper, section 6).

Each gives at most one command per cycle, decides from the current percept alone and keeps no
state. Powers are those of rcssserver, 0 to 100; speeds are in m/cycle.
"""

from __future__ import annotations

import math

from hitab_core import BasicBehavior
from keepaway_world import percept
from keepaway_world.body import NO_PLAYER, YELL, KeeperBody
from keepaway_world.features import direction_to
from keepaway_world.game.angles import wrapped
from keepaway_world.game.interception import FULL, power_to_rest
from keepaway_world.game.kicking import kick_acceleration, kick_power, off_place, pass_speed
from keepaway_world.percept import BALL

FAST, MEDIUM, SLOW = 100.0, 90.0, 75.0

AT_REST = 0.1  # m/cycle: a ball that looks slower than this is left alone

OPEN_STEP = 3.0  # m: how far ahead GetOpen looks down its potential field
OPEN_ARRIVED = 0.5  # m: a keeper does not go to a place that is closer than this
TURN_WHEN_OFF = math.radians(10.0)  # a keeper that is off by less than this dashes


def go_fast(body: KeeperBody) -> None:
    """Dash straight ahead with power 100."""
    body.dash(FAST)


def go_medium(body: KeeperBody) -> None:
    """Dash straight ahead with power 90."""
    body.dash(MEDIUM)


def go_slow(body: KeeperBody) -> None:
    """Dash straight ahead with power 75."""
    body.dash(SLOW)


def stop(body: KeeperBody) -> None:
    """Come to rest, and stop a rolling ball within kicking range.

    A keeper that does not dash comes to rest within a meter. Whether the paper's Stop affects the
    ball is not stated. But players cannot collide with the ball, so a ball rolls past every
    receiver that does not stop it with a kick, and no pass could ever be completed.
    """
    if not body.ball_is_kickable:
        return
    vx, vy = body.ball_velocity
    speed = math.hypot(vx, vy)
    if speed > AT_REST:
        distance, direction = body.values[BALL], body.values[BALL + 1]
        power = kick_power(body.parameters, speed, distance, direction)
        body.kick(power, wrapped(math.atan2(-vy, -vx) - body.heading))


def turn_to_ball(body: KeeperBody) -> None:
    """Turn to face the ball; at speed, a large turn takes more than one cycle."""
    turn_to(body, BALL)


def turn_to(body: KeeperBody, place: int) -> None:
    """Turn to face the ball, a player or a corner; do nothing if there is no such player."""
    direction = direction_to(body, place)
    if direction and not math.isnan(direction):
        body.turn_by(direction)


def most_open_keeper(body: KeeperBody) -> int:
    """Return the place of the teammate to pass to.

    The most open teammate has the largest angle, seen from the passer, to the closest taker; on a
    tie, the lowest number. Without takers, the closest teammate is chosen.
    """
    taker = body.closest_taker()
    if taker == NO_PLAYER:
        return body.closest_keeper()
    return max(body.others, key=lambda place: body.angle_between(place, taker), default=NO_PLAYER)


def pass_ball(body: KeeperBody) -> None:
    """Kick the ball once to the most open teammate and yell its number.

    The ball should arrive at 1.2 m/cycle. The kick accounts for the ball's motion and its place
    beside the player. If one kick is too weak, the ball leaves in the right direction as fast as
    possible. A ball that is not kickable is left alone.
    """
    pass_to(body, most_open_keeper(body))


def pass_to(body: KeeperBody, receiver: int) -> None:
    """Kick the ball once to the teammate at a place, as in `pass_ball`.

    A ball that is not kickable is left alone, and so is any ball if there is no such teammate.
    """
    if not body.ball_is_kickable or receiver < 0:
        return
    ball_x, ball_y = body.vector_to(BALL)
    receiver_x, receiver_y = body.vector_to(receiver)
    dx, dy = receiver_x - ball_x, receiver_y - ball_y
    send_ball(body, math.atan2(dy, dx), pass_speed(body.parameters, math.hypot(dx, dy)))
    body.say(YELL.format(body.number_at(receiver)))


def send_ball(body: KeeperBody, bearing: float, speed: float) -> None:
    """Kick a kickable ball along ``bearing``, rad, with ``speed``, m/cycle."""
    p, values = body.parameters, body.values
    c, s = math.cos(bearing), math.sin(bearing)
    vx, vy = body.ball_velocity
    distance, direction = values[BALL], values[BALL + 1]
    along, across = kick_acceleration(
        p,
        vx * c + vy * s,
        vy * c - vx * s,
        speed,
        100.0 * p.kick_rate * (1.0 - off_place(p, distance, direction)),
    )
    power = kick_power(p, math.hypot(along, across), distance, direction)
    body.kick(power, wrapped(bearing + math.atan2(across, along) - body.heading))


def get_open(body: KeeperBody) -> None:
    """Move away from the teammates, never out of the circle around the box's center.

    In a simple potential field, each teammate repels the keeper with a force of 1/distance. The
    keeper goes a step along the sum of the forces, or to the nearest point on the circle (10 m in
    the paper's box). It turns if that place is not ahead; otherwise it dashes to come to rest
    there.
    """
    x, y = body.position
    fx = fy = 0.0
    for place in body.others:
        dx, dy = body.vector_to(place)
        squared = max(dx * dx + dy * dy, 1e-6)
        fx -= dx / squared
        fy -= dy / squared
    force = math.hypot(fx, fy)
    if force < 1e-9:
        return
    aim_x, aim_y = x + OPEN_STEP * fx / force, y + OPEN_STEP * fy / force
    radius = open_radius(body)
    from_center = math.hypot(aim_x, aim_y)
    if from_center > radius:
        aim_x *= radius / from_center
        aim_y *= radius / from_center
    dx, dy = aim_x - x, aim_y - y
    if math.hypot(dx, dy) < OPEN_ARRIVED:
        return
    go_by(body, dx, dy)


def go_by(body: KeeperBody, dx: float, dy: float) -> None:
    """Turn towards a place, given relative to the keeper, or dash to come to rest there."""
    off = wrapped(math.atan2(dy, dx) - body.heading)
    if abs(off) > TURN_WHEN_OFF:
        body.turn_by(off)
        return
    vx, vy = body.velocity
    ahead = vx * math.cos(body.heading) + vy * math.sin(body.heading)
    body.dash(power_to_rest(body.parameters, math.hypot(dx, dy), ahead, FULL))


def open_radius(body: KeeperBody) -> float:
    """Return GetOpen's largest distance from the center, m: the body stays within half the box."""
    half = min(body.values[percept.WIDTH], body.values[percept.HEIGHT]) / 2.0
    return half - body.parameters.player_radius


BEHAVIORS = (
    BasicBehavior("GoFast", go_fast, description="dash straight ahead with power 100"),
    BasicBehavior("GoMedium", go_medium, description="dash straight ahead with power 90"),
    BasicBehavior("GoSlow", go_slow, description="dash straight ahead with power 75"),
    BasicBehavior("Stop", stop, description="come to rest, and stop a ball within reach"),
    BasicBehavior("TurnToBall", turn_to_ball, description="turn to face the ball"),
    BasicBehavior(
        "Pass",
        pass_ball,
        one_shot=True,
        description="kick the ball to the most open teammate and yell to it",
    ),
    BasicBehavior(
        "GetOpen",
        get_open,
        description="move away from teammates, within 10 m of the center",
    ),
    BasicBehavior("TurnTo", turn_to, parameters=("X",), description="turn to face X"),
)
