"""Angles: counter-clockwise radians from the x axis."""

import math

PI = math.pi


def wrapped(angle: float) -> float:
    """Return ``angle``, in rad, on [-pi, pi]."""
    if -PI <= angle <= PI:
        return angle
    return math.remainder(angle, 2.0 * PI)
