"""Means, their intervals, and what is better of two by the same episodes."""

import math

import numpy as np
import pytest

from hitab_world.evaluation import Comparison, Estimate, endings, estimate, measures_of, student_t
from hitab_world.world import EpisodeResult, Measure, WorldError

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


def result(seconds: float, ended: str = "out", **measures: float) -> EpisodeResult:
    return EpisodeResult(0, 1, 10, seconds, ended, measures)


@pytest.mark.parametrize(("better", "verdict"), [("more", "better"), ("less", "worse")])
def test_two_are_compared_pair_by_pair_though_each_varies_much(better, verdict):
    seconds = [5.0, 50.0, 500.0, 20.0]
    played = [(result(s + 1.0 + 0.1 * i), result(s)) for i, s in enumerate(seconds)]
    compared = Comparison.of(Measure("seconds", "s", better), played)
    one, other = compared.estimates
    assert one.low < other.mean < one.high  # apart, they tell nothing
    assert compared.difference.mean == pytest.approx(1.15)
    assert compared.verdict == verdict
    data = compared.to_json()
    assert data["difference"]["verdict"] == verdict
    assert data["against"]["episodes"] == seconds


def test_nothing_is_better_than_itself_or_by_one_episode():
    alike = [(result(s), result(s)) for s in (1.0, 2.0, 3.0)]
    assert Comparison.of(Measure("seconds"), alike).verdict == ""
    assert Comparison.of(Measure("seconds"), [(result(9.0), result(1.0))]).verdict == ""


def test_a_world_that_declares_no_measures_has_those_of_its_results():
    played = [result(2.0, boxes=3.0), result(1.0, "", boxes=4.0)]
    assert [m.name for m in measures_of(object(), played)] == ["seconds", "boxes"]
    assert Measure("boxes").of(played[0]) == 3.0
    assert math.isnan(Measure("passes").of(played[0]))
    assert endings([(one,) for one in played]) == [{"out": 1, "broken off": 1}]
    with pytest.raises(WorldError, match=r'"most".*less, more'):
        Measure("boxes", better="most")
