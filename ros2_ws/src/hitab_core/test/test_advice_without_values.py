"""Advice where examples, readings or the situation asked about lack values."""

import math

from hitab_core.advice.ambiguity import ambiguities
from hitab_core.advice.evidence import Evidence
from hitab_core.domain import BOOLEAN_SCALE, Scale
from hitab_core.example import Example, ExampleKind

METERS = Scale()
NAMES = ("Taker", "Kickable")
SCALES = (METERS, BOOLEAN_SCALE)
UNITS = ("m", "")
CHASING = [
    ("Go", (12.0, 0.0), "Go", True),
    ("Go", (8.0, 1.0), "Stop", False),
]


def evidence(rows, scales=SCALES, names=NAMES, units=UNITS):
    """Return the evidence of rows (state, values, next state, is default)."""
    kinds = (ExampleKind.DEMONSTRATED, ExampleKind.DEFAULT)
    examples = [Example(*row[:3], kinds[row[3]]) for row in rows]
    return Evidence.of(rows[0][0], examples, scales, names, units)


def test_examples_and_readings_may_lack_values():
    rows = [*CHASING, ("Go", (math.nan, 0.0), "Go", False), ("Go", (math.nan, 1.0), "Stop", False)]
    readings = [("At", v) for v in ([12.5, 1.0], [math.nan, 0.0], [3.0, math.nan])]
    assert ambiguities(evidence(rows), readings) == []  # the values there tell which
    (question,) = ambiguities(evidence(CHASING), readings)
    assert question.situation == (12.5, 1.0)
