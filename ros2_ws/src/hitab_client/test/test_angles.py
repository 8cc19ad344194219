"""Directions, also in answers to questions, are shown from minus to plus half a turn."""

import math

import pytest

from hitab_client import as_direction


def test_a_direction_is_shown_in_one_range():
    for value, unit, kind, shown in [
        (math.radians(241.4), "rad", "toroidal", math.radians(-118.6)),
        (351.5, "deg", "toroidal", -8.5),
        (-63.6, "deg", "toroidal", -63.6),
        (241.4, "deg", "continuous", 241.4),
        (241.4, "m", "toroidal", 241.4),
        (math.nan, "rad", "toroidal", math.nan),
    ]:
        assert as_direction(value, unit, kind) == pytest.approx(shown, nan_ok=True)
