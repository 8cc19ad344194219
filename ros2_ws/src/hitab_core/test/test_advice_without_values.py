"""Advice where examples, or the situation asked about, lack values."""

import math

import numpy as np

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.unshown import unshown
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example

SCALES = (Scale(), Scale(FeatureKind.BOOLEAN))


def test_examples_and_what_was_met_may_lack_values():
    rows = [((12.0, 0.0), "Go"), ((11.0, math.nan), "Go"), ((8.0, 1.0), "Stop")]
    examples = [Example("Go", values, to) for values, to in rows]
    given = Evidence.of("Go", examples, SCALES, ("Taker", "Kickable"), ("m", ""))
    met = [[200.0, math.nan], [12.0, 0.0]]
    found = unshown(given, met, (), np.zeros(3, np.bool_))
    assert found is not None
    assert found.situation[0] == 200.0
    assert found.decided == "Go", "what is most probable there"
