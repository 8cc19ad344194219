"""Keepaway with one feature more."""

from dataclasses import replace
from math import pi, remainder

from hitab_core import Feature, FeatureKind
from keepaway_world.domain import DOMAIN as KEEPAWAY

DISTANCE, DIRECTION = (KEEPAWAY.features[name].read for name in ("DistanceTo", "DirectionTo"))


def between(body, x, y):
    """Whether Y is nearly on the line to X, and nearer."""
    apart = remainder(DIRECTION(body, y) - DIRECTION(body, x), 2 * pi)
    return abs(apart) < 0.3 and DISTANCE(body, y) < DISTANCE(body, x)


BETWEEN = Feature("Between", between, FeatureKind.BOOLEAN, ("X", "Y"), description=between.__doc__)
DOMAIN = replace(KEEPAWAY, features={**KEEPAWAY.features, "Between": BETWEEN})
