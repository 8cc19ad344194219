"""Directions for people: the same range everywhere, however they were recorded."""

from __future__ import annotations

import math

from hitab_core import RADIANS, FeatureKind, shown_unit

TURNS = {RADIANS: math.tau, shown_unit(RADIANS): 360.0}


def as_direction(value: float, unit: str, kind: str) -> float:
    """Return a value of a feature; a direction from minus to plus half a turn.

    An answer to a question may be recorded at 241 degrees, where a sensor reads -119.

    Args:
        value: of the feature.
        unit: of the feature.
        kind: of the feature; only those on a circle are directions.

    Examples:
        >>> as_direction(241.0, "deg", "toroidal"), as_direction(241.0, "deg", "continuous")
        (-119.0, 241.0)
    """
    if kind != FeatureKind.TOROIDAL or unit not in TURNS or not math.isfinite(value):
        return value
    return math.remainder(value, TURNS[unit])
