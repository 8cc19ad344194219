"""The kick model of rcssserver, and how hard to kick for a pass.

Used by the physics, by the takers and by the keepers' Pass. Speeds are in m/cycle.
"""

from __future__ import annotations

import math

from keepaway_world.parameters import KeepawayParameters

PASS_ARRIVAL_SPEED = 1.2  # m/cycle at which a pass reaches its receiver (UT Austin keepaway)


def off_place(p: KeepawayParameters, distance: float, direction: float) -> float:
    """Return the fraction of a kick's power that is lost to the ball's position.

    It is 0 for a ball that touches the player in front, 0.25 for one behind or at the edge of the
    kickable area, 0.5 for both. A ball inside the player, possible only without collisions, is
    kicked like one that touches.

    Args:
        p: the mechanics.
        distance: distance between the centers, m.
        direction: direction of the ball relative to the body, rad on [-pi, pi].
    """
    away = max(distance - p.contact, 0.0) / p.kickable_margin
    return 0.25 * abs(direction) / math.pi + 0.25 * away


def kick_power(
    p: KeepawayParameters, acceleration: float, distance: float, direction: float
) -> float:
    """Return the power for an acceleration, m/cycle², of a ball in this place; may exceed 100."""
    return acceleration / (p.kick_rate * (1.0 - off_place(p, distance, direction)))


def pass_speed(p: KeepawayParameters, distance: float) -> float:
    """Return the speed, m/cycle, with which a ball must start to arrive at 1.2 m/cycle.

    This is the UT Austin players' formula (the paper, section 6, footnote 2), which rounds the
    number of cycles for which the ball rolls.
    """
    growth = 1.0 / p.ball_decay
    cycles = math.log(1.0 + distance * (growth - 1.0) / PASS_ARRIVAL_SPEED) / math.log(growth)
    return min(PASS_ARRIVAL_SPEED * growth ** round(cycles), p.ball_speed_max)


def kick_acceleration(
    p: KeepawayParameters, vx: float, vy: float, wanted: float, reachable: float
) -> tuple[float, float]:
    """Return the acceleration, m/cycle², of one kick that sends the ball along +x.

    If one kick cannot reach ``wanted``, direction matters more than speed: the ball is kicked as
    hard as possible along +x and leaves slower. If it comes in too fast even for that, the kick
    gets as close to the wanted velocity as possible.

    Args:
        p: the mechanics.
        vx, vy: the ball's velocity along and across the wanted direction, m/cycle.
        wanted: speed along +x after the kick, m/cycle.
        reachable: largest acceleration of a kick with full power, m/cycle².
    """
    reachable = min(reachable, p.ball_acceleration_max)
    ax, ay = wanted - vx, -vy
    if math.hypot(ax, ay) <= reachable:
        return ax, ay
    if abs(vy) < reachable:
        along = math.sqrt(reachable * reachable - vy * vy)
        if vx + along > 0.0:
            return along, -vy
    scale = reachable / math.hypot(ax, ay)
    return ax * scale, ay * scale
