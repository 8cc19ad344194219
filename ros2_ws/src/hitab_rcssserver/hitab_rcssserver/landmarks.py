"""The place of a player, computed from the landmarks in its sight.

All numbers are in the server's units and axes: m, y points down, degrees clockwise. Places are
complex numbers.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable, Mapping
from typing import TypeAlias

from hitab_rcssserver.messages import SeenObject

Pose: TypeAlias = tuple[complex, float]
"""A place, and the direction in which the neck points."""

_LENGTH, _WIDTH = 105.0, 68.0
_PENALTY_LENGTH, _PENALTY_WIDTH = 16.5, 40.32
_GOAL_WIDTH = 14.02
_OUTSIDE = 5.0  # distance of the flags from the edge of the field
_NEAR = 1.0  # m^2; below, rounding to 0.1 m dominates the error of a distance


def _landmarks() -> dict[tuple[str, ...], complex]:
    """Return the positions of all flags and goals, by the server's names."""
    x, y = _LENGTH / 2.0, _WIDTH / 2.0
    found = {("f", "c"): 0j, ("f", "c", "t"): complex(0.0, -y), ("f", "c", "b"): complex(0.0, y)}
    for side, left in (("l", -1.0), ("r", 1.0)):
        found["g", side] = complex(left * x)
        found["f", side, "0"] = complex(left * (x + _OUTSIDE))
        found["f", "p", side, "c"] = complex(left * (x - _PENALTY_LENGTH))
        for end, up in (("t", -1.0), ("b", 1.0)):
            found["f", side, end] = complex(left * x, up * y)
            found["f", "g", side, end] = complex(left * x, up * _GOAL_WIDTH / 2.0)
            penalty = complex(left * (x - _PENALTY_LENGTH), up * _PENALTY_WIDTH / 2.0)
            found["f", "p", side, end] = penalty
            found["f", end, "0"] = complex(0.0, up * (y + _OUTSIDE))
            for far in (10, 20, 30):
                found["f", side, end, f"{far}"] = complex(left * (x + _OUTSIDE), up * far)
            for far in (10, 20, 30, 40, 50):
                found["f", end, side, f"{far}"] = complex(left * far, up * (y + _OUTSIDE))
    return found


LANDMARKS: Mapping[tuple[str, ...], complex] = _landmarks()


def away(distance: float, direction: float) -> complex:
    """Return the vector of a length in a direction, degrees."""
    return cmath.rect(distance, math.radians(direction))


def locate(objects: Iterable[SeenObject]) -> Pose | None:
    """Return the pose from which the landmarks look like this; None if fewer than two are seen.

    The pose is the least-squares fit of the seen to the true positions. Near landmarks weigh more,
    since the error of a distance grows with the distance.
    """
    pairs = [
        (1.0 / (seen.distance**2 + _NEAR), away(seen.distance, seen.direction), place)
        for seen in objects
        if (place := LANDMARKS.get(seen.name)) is not None and not math.isnan(seen.distance)
    ]
    if len(pairs) < 2:
        return None
    total = sum(weight for weight, _, _ in pairs)
    mean_seen = sum(weight * seen for weight, seen, _ in pairs) / total
    mean_true = sum(weight * true for weight, _, true in pairs) / total
    turned = sum(w * (s - mean_seen).conjugate() * (t - mean_true) for w, s, t in pairs)
    neck = math.atan2(turned.imag, turned.real)  # where it is next to 0, cmath.phase may raise
    return mean_true - cmath.rect(1.0, neck) * mean_seen, math.degrees(neck)
