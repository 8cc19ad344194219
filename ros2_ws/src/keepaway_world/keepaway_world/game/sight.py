"""A player's sight: exact, or quantised as in rcssserver.

Distances are in m, speeds in m/cycle, angles in rad. rcssserver rounds the logarithm of a
distance to steps of 0.1 and the result to 0.1 m, directions to whole degrees, the change of a
distance to 0.02 of that distance and the change of a direction to 0.1 degrees a cycle.
"""

from __future__ import annotations

import math

LOG_STEP = 0.1
DISTANCE_STEP = 0.1
DIRECTION_STEP = math.radians(1.0)
DISTANCE_CHANGE_STEP = 0.02  # of the distance itself
DIRECTION_CHANGE_STEP = math.radians(0.1)

_NEAREST = -60  # e**-6 m and below is 0 m
_FARTHEST = 80  # e**8 m, about 3 km
_SEEN_DISTANCES = tuple(
    round(math.exp(step * LOG_STEP) / DISTANCE_STEP) / 10.0
    for step in range(_NEAREST, _FARTHEST + 1)
)


def quantised_distance(distance: float) -> float:
    """Return a distance as seen: in steps that grow with the distance."""
    if distance < 1e-3:
        return 0.0
    step = round(math.log(distance) * 10.0)
    return _SEEN_DISTANCES[min(step, _FARTHEST) - _NEAREST] if step > _NEAREST else 0.0


def quantised_direction(direction: float) -> float:
    """Return a direction rounded to whole degrees."""
    return round(direction / DIRECTION_STEP) * DIRECTION_STEP


def seen_velocity(
    dx: float, dy: float, vx: float, vy: float, seen_distance: float, seen_bearing: float
) -> tuple[float, float]:
    """Return an object's velocity relative to the observer, as seen.

    The observer sees the quantised rates of change of distance and direction, and combines them
    with the perceived distance and direction.

    Args:
        dx, dy: position relative to the observer.
        vx, vy: velocity relative to the observer's.
        seen_distance: quantised distance.
        seen_bearing: quantised direction, from the x axis of the same frame as ``dx, dy``.
    """
    squared = dx * dx + dy * dy
    if squared < 1e-12:
        return 0.0, 0.0
    closing = (vx * dx + vy * dy) / squared  # relative change of the distance
    turning = (vy * dx - vx * dy) / squared  # rad/cycle
    along = seen_distance * round(closing / DISTANCE_CHANGE_STEP) * DISTANCE_CHANGE_STEP
    across = seen_distance * round(turning / DIRECTION_CHANGE_STEP) * DIRECTION_CHANGE_STEP
    c, s = math.cos(seen_bearing), math.sin(seen_bearing)
    return along * c - across * s, along * s + across * c
