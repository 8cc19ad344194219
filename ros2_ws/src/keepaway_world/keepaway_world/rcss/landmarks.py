"""Computes where a player is from the landmarks that it sees.

All figures are the server's: m, y points down, degrees clockwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import TypeAlias

from keepaway_world.rcss.messages import SeenObject

Point: TypeAlias = tuple[float, float]
Pose: TypeAlias = tuple[float, float, float]
"""x, y and the direction in which the neck points."""

_LENGTH, _WIDTH = 105.0, 68.0
_PENALTY_LENGTH, _PENALTY_WIDTH = 16.5, 40.32
_GOAL_WIDTH = 14.02
_OUTSIDE = 5.0  # distance of the flags from the edge of the field
_NEAR = 1.0  # m^2; below, rounding to 0.1 m dominates the error of a distance


def _landmarks() -> dict[tuple[str, ...], Point]:
    """Return the positions of all flags and goals, by the server's names."""
    half_length, half_width = _LENGTH / 2.0, _WIDTH / 2.0
    across = {"l": -half_length, "c": 0.0, "r": half_length}
    down = {"t": -half_width, "c": 0.0, "b": half_width}
    found: dict[tuple[str, ...], Point] = {("f", "c"): (0.0, 0.0)}
    for side in "lr":
        x = across[side]
        sign = math.copysign(1.0, x)
        found["g", side] = x, 0.0
        for end in "tcb":
            penalty = x - sign * _PENALTY_LENGTH
            share = down[end] / _WIDTH
            found["f", "p", side, end] = penalty, share * _PENALTY_WIDTH
            if end != "c":
                found["f", "g", side, end] = x, share * _GOAL_WIDTH
        found["f", side, "0"] = x + sign * _OUTSIDE, 0.0
        for end in "tb":
            for away in (10.0, 20.0, 30.0):
                y = math.copysign(away, down[end])
                found["f", side, end, f"{away:g}"] = x + sign * _OUTSIDE, y
    for end in "tb":
        y = down[end]
        outside = y + math.copysign(_OUTSIDE, y)
        for place, x in across.items():
            found["f", place, end] = x, y
        found["f", end, "0"] = 0.0, outside
        for side in "lr":
            for away in (10.0, 20.0, 30.0, 40.0, 50.0):
                x = math.copysign(away, across[side])
                found["f", end, side, f"{away:g}"] = x, outside
    return found


LANDMARKS: Mapping[tuple[str, ...], Point] = _landmarks()


def locate(objects: Iterable[SeenObject]) -> Pose | None:
    """Return the pose from which the landmarks look like this; None if fewer than two are seen.

    It is the least-squares fit of the seen to the true positions, weighted by nearness, since the
    error of a distance grows with it.
    """
    pairs = []
    for seen in objects:
        place = LANDMARKS.get(seen.name)
        if place is not None and not math.isnan(seen.distance):
            angle = math.radians(seen.direction)
            relative = seen.distance * math.cos(angle), seen.distance * math.sin(angle)
            pairs.append((1.0 / (seen.distance**2 + _NEAR), relative, place))
    if len(pairs) < 2:
        return None
    total = sum(weight for weight, _, _ in pairs)
    rx = sum(weight * r[0] for weight, r, _ in pairs) / total
    ry = sum(weight * r[1] for weight, r, _ in pairs) / total
    px = sum(weight * p[0] for weight, _, p in pairs) / total
    py = sum(weight * p[1] for weight, _, p in pairs) / total
    dot = cross = 0.0
    for weight, (ax, ay), (bx, by) in pairs:
        ax, ay, bx, by = ax - rx, ay - ry, bx - px, by - py
        dot += weight * (ax * bx + ay * by)
        cross += weight * (ax * by - ay * bx)
    neck = math.atan2(cross, dot)
    c, s = math.cos(neck), math.sin(neck)
    return px - (c * rx - s * ry), py - (s * rx + c * ry), math.degrees(neck)
