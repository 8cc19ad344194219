"""A command counts for the situation that the person saw when it was due, in the world's time."""

from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import WorldStatus

from hitab_client.demonstrating.key_actions import EARLIER_SECONDS, earlier, simulated


def world(mode: str = "running", pace: str = "realtime", factor: float = 1.0) -> Any:
    status = WorldStatus(mode=mode, pace=pace, factor=factor)
    return SimpleNamespace(status=status, speed=3.0)


def test_a_persons_time_is_scaled_by_the_pace_of_the_world_and_is_nothing_while_it_is_paused():
    def passed(world: Any) -> float:
        return simulated(0.3, world.status, world.speed)

    assert passed(world()) == 0.3
    assert passed(world(factor=2.0)) == pytest.approx(0.6)
    assert passed(world(pace="lockstep")) == pytest.approx(0.9)
    assert passed(world("paused")) == 0.0
    assert simulated(0.3, None) == 0.3, "a robot's time is that of the person"


def test_a_command_is_put_earlier_by_the_pace_of_the_world_even_while_it_is_paused():
    assert earlier(world(factor=2.0)) == pytest.approx(2 * EARLIER_SECONDS)
    assert earlier(world("paused", factor=2.0)) == pytest.approx(2 * EARLIER_SECONDS)
    still = SimpleNamespace(status=WorldStatus(mode="paused", pace="lockstep"), speed=0.0)
    assert earlier(still) == EARLIER_SECONDS


def test_a_world_that_is_slower_while_an_agent_is_taught_slows_a_persons_time():
    taught = WorldStatus(mode="running", pace="realtime", factor=2.0, teaching=0.5, taught=True)
    assert simulated(0.3, taught) == pytest.approx(0.3)
    still = WorldStatus(mode="paused", pace="realtime", factor=2.0, teaching=0.5, taught=True)
    assert earlier(SimpleNamespace(status=still, speed=1.0)) == pytest.approx(EARLIER_SECONDS)
    assert still.mode == "paused"
    live = WorldStatus(mode="running", pace="realtime", factor=2.0, teaching=0.0, taught=True)
    assert simulated(0.3, live) == pytest.approx(0.6), "it cannot be slowed down"
