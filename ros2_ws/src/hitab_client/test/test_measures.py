"""Means of measures and their intervals."""

import math

import numpy as np
import pytest

from hitab_client.measures import Estimate, estimate, student_t

TABLE = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 9: 2.262, 19: 2.093, 99: 1.984}
"""Printed in any textbook, for 95 %."""


@pytest.mark.parametrize("freedom", TABLE)
def test_the_interval_is_as_wide_as_students_table_says(freedom):
    assert student_t(freedom) == pytest.approx(TABLE[freedom], rel=2e-3)


def test_an_interval_covers_the_true_mean_about_as_often_as_it_claims():
    random = np.random.default_rng(4)
    found = [estimate(random.normal(3.0, 2.0, 4).tolist()) for _ in range(4000)]
    assert np.mean([e.low < 3.0 < e.high for e in found]) == pytest.approx(0.95, abs=0.01)


def test_a_mean_has_the_standard_error_and_what_is_unknown_does_not_count():
    values = [1.0, 2.0, 4.0, 9.0, math.nan]
    found = estimate(values)
    assert found.mean == 4.0
    assert found.se == pytest.approx(np.std(values[:4], ddof=1) / 2.0)
    assert found.high - found.mean == pytest.approx(found.mean - found.low)
    assert estimate([]) == Estimate(None)
    assert estimate([7.0]) == Estimate(7.0)
