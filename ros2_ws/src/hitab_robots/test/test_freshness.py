"""A reading is as old as it is, whatever its stamp says."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_robots.freshness import Freshness

PATIENCE = 0.5
NOW = 1e6


@pytest.fixture
def sensor():
    return Freshness(1, PATIENCE)


def value(sensor, now):
    (found,) = sensor.values(now)
    return found


@pytest.mark.parametrize("stamp", [NOW, 0.0, NOW + 3600.0, math.nan, -5.0])
def test_a_reading_has_a_value_until_it_is_too_old(sensor, stamp):
    assert sensor.take([1.0], stamp, NOW)
    assert value(sensor, NOW + PATIENCE) == 1.0
    assert math.isnan(value(sensor, NOW + PATIENCE + 0.01))


def test_a_stale_reading_has_no_value_and_the_clocks_are_suspected(sensor):
    sensor.take([1.0], NOW - 3600.0, NOW)
    assert math.isnan(value(sensor, NOW))
    assert "too old" in sensor.trouble
    sensor.take([1.0], NOW, NOW)
    assert sensor.trouble == ""


def test_a_stamp_from_the_future_keeps_nothing_fresh_for_ever(sensor):
    sensor.take([1.0], NOW + 3600.0, NOW)
    assert "ahead" in sensor.trouble
    assert math.isnan(value(sensor, NOW + 1.0))


def test_in_a_simulation_a_stamp_that_is_ahead_of_a_late_clock_is_no_trouble():
    sensor = Freshness(1, PATIENCE, ahead=math.inf)
    assert sensor.take([1.0], NOW + 0.3, NOW)
    assert sensor.trouble == ""
    assert value(sensor, NOW + PATIENCE) == 1.0
    assert math.isnan(value(sensor, NOW + PATIENCE + 0.01))


def test_a_clock_that_was_set_back_is_followed_once_the_last_reading_is_too_old(sensor):
    sensor.take([1.0], NOW + 0.05, NOW)
    assert not sensor.take([2.0], 5.0, NOW + 0.1)
    assert sensor.take([3.0], NOW - 0.1, NOW + 0.6) is True
    assert sensor.take([4.0], NOW + 0.61, NOW + 0.62)
    assert value(sensor, NOW + 0.63) == 4.0


def test_a_simulation_that_starts_again_is_followed_at_once(sensor):
    sensor.take([1.0], NOW, NOW)
    assert math.isnan(value(sensor, 0.1))
    assert sensor.take([2.0], 0.1, 0.1)
    assert value(sensor, 0.2) == 2.0


steps = st.lists(
    st.tuples(st.floats(0.0, 2.0), st.floats(-1e4, 1e4) | st.just(math.nan)), max_size=30
)


@given(steps, st.floats(0.0, 10.0))
def test_no_value_is_older_than_patience_by_arrival(steps, later):
    sensor = Freshness(1, PATIENCE)
    now, arrivals = NOW, [-math.inf]
    for pause, stamp in steps:
        now += pause
        sensor.take([now], stamp, now)
        arrivals.append(now)
    found = value(sensor, now + later)
    if not math.isnan(found):
        assert found in arrivals
        assert now + later - found <= PATIENCE + 1e-9
