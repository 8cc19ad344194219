"""Comparison of two casts by the same episodes, and the measures of a world."""

import math

import pytest

from hitab_bringup.evaluation import Comparison, endings, measures_of
from hitab_world.world import EpisodeResult, Measure, WorldError


def result(seconds: float, ended: str = "out", **measures: float) -> EpisodeResult:
    return EpisodeResult(0, 1, 10, seconds, ended, measures)


@pytest.mark.parametrize(("better", "verdict"), [("more", "better"), ("less", "worse")])
def test_two_are_compared_pair_by_pair_though_each_varies_much(better, verdict):
    seconds = [5.0, 50.0, 500.0, 20.0]
    played = [(result(s + 1.0 + 0.1 * i), result(s)) for i, s in enumerate(seconds)]
    compared = Comparison.of(Measure("seconds", "s", better), played)
    one, other = compared.estimates
    assert one.low < other.mean < one.high  # unpaired, the difference is not significant
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
