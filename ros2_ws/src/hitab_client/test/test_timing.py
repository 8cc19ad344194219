"""A command counts for what its person saw when it was due, in the world's time."""

from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import WorldStatus

from hitab_client.demonstrating.commanding import EARLIER_SECONDS, due, earlier


def world(mode: str = "running", pace: str = "realtime", factor: float = 1.0) -> Any:
    status = WorldStatus(mode=mode, pace=pace, factor=factor)
    return SimpleNamespace(status=status, speed=3.0)


def test_a_reaction_time_is_scaled_by_the_pace_of_the_world_and_is_nothing_while_it_is_paused():
    assert due(world(), 0.3, 70) == (0.3, 70)
    assert due(world(factor=2.0), 0.3, 70) == (pytest.approx(0.6), 70)
    assert due(world(pace="lockstep"), 0.3, 70) == (pytest.approx(0.9), 70)
    assert due(world("paused"), 0.3, 70) == (0.0, 0)
    without = SimpleNamespace(status=None, speed=1.0)
    assert due(without, 0.3, 0) == (0.3, 0), "a robot's time is that of the person"


def test_a_command_is_put_earlier_by_the_pace_of_the_world_even_while_it_is_paused():
    assert earlier(world(factor=2.0)) == pytest.approx(2 * EARLIER_SECONDS)
    assert earlier(world("paused", factor=2.0)) == pytest.approx(2 * EARLIER_SECONDS)
    still = SimpleNamespace(status=WorldStatus(mode="paused", pace="lockstep"), speed=0.0)
    assert earlier(still) == EARLIER_SECONDS
