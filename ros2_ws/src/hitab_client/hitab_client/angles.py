"""Directions as they are shown to people: always from minus to plus half a turn."""

from __future__ import annotations

import math

from hitab_core import RADIANS, FeatureKind, shown_unit

TURNS = {RADIANS: math.tau, shown_unit(RADIANS): 360.0}


def as_direction(value: float, unit: str, kind: str) -> float:
    """Return a feature's value for display; directions range from minus to plus half a turn.

    An answer to a question may be recorded at 241 degrees, where a sensor reads -119.

    Args:
        value: the feature's value.
        unit: the feature's unit.
        kind: the feature's kind; only circular features are directions.

    Examples:
        >>> as_direction(241.0, "deg", "toroidal"), as_direction(241.0, "deg", "continuous")
        (-119.0, 241.0)
    """
    if kind != FeatureKind.TOROIDAL or unit not in TURNS or not math.isfinite(value):
        return value
    return math.remainder(value, TURNS[unit])
