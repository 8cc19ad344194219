"""A world is put back to any cycle of its last minute, and plays the same again."""

from pathlib import Path
from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_core import HitabError
from hitab_world import SimulationWorld
from hitab_world.simulating.last_minute import LastMinute
from hitab_world.simulating.simulation import SimulationParameters

CORRIDOR = Path(__file__).parents[4] / "examples/corridor.py"


class Played:
    """A world that is played at random, and its snapshot before each cycle."""

    def __init__(self, seconds_of_a_snapshot: float = 0.0, speed: float = 1.0) -> None:
        self.world = SimulationWorld(SimulationParameters(str(CORRIDOR), 2), 5)
        self._now, self._takes = 0.0, seconds_of_a_snapshot
        self.minute = LastMinute(self.world, self._clock)
        self.random, self.speed = Random(1), speed
        self.snapshots: dict[int, Any] = {}
        self.actions: dict[int, Any] = {}

    def _clock(self) -> float:
        self._now += self._takes
        return self._now

    def play(self, cycles: int) -> None:
        for _ in range(cycles):
            cycle = self.world.cycle
            chosen = {
                name: ([self.speed * self.random.uniform(-1, 1)], "") for name in self.world.agents
            }
            self._step(self.actions.setdefault(cycle, chosen))

    def _step(self, actions: Any) -> None:
        self.snapshots[self.world.cycle] = self.world.snapshot()
        self.minute.note(actions)
        if self.world.step(actions):
            self.world.reset()


@settings(deadline=None, max_examples=40)
@given(st.integers(1, 90), st.data(), st.sampled_from([0.0, 1e-3]))
def test_a_world_plays_the_same_again_from_any_cycle_kept(cycles, data, takes):
    played = Played(takes)
    played.play(cycles)
    for _ in range(3):
        if not played.minute.oldest:
            played.play(1)  # an episode has just begun
        first = dict(played.snapshots)
        back = data.draw(st.integers(played.minute.oldest, played.world.cycle), "back to")
        if back == played.world.cycle:
            first[back] = played.world.snapshot()
        played.minute.go_back(back)
        assert played.world.snapshot() == first[back]
        played.play(max(first) + 1 - back)
        assert {cycle: played.snapshots[cycle] for cycle in first} == first


def test_an_episode_that_is_over_is_forgotten():
    played = Played()
    played.play(10)
    assert played.minute.oldest == 1
    played.world.reset()
    assert played.minute.oldest == 0
    with pytest.raises(HitabError, match=r"no earlier cycle yet; let the world run"):
        played.minute.go_back(5)
    played.play(3)
    assert played.minute.oldest == 10
    with pytest.raises(HitabError, match=r"from 10 to 13"):
        played.minute.go_back(9)


def test_a_minute_is_kept():
    played = Played(speed=0.0)  # nobody goes too far, which would end the episode
    played.world.cycle_seconds = 1.0
    played.play(200)
    oldest = played.minute.oldest
    assert 200 - oldest in (60, 61)
    played.minute.go_back(oldest)
    assert played.world.snapshot() == played.snapshots[oldest]


def test_a_world_that_cannot_play_again_is_as_it_was(monkeypatch):
    played = Played()
    played.play(8)
    present = played.world.snapshot()
    monkeypatch.setattr(played.world, "step", lambda actions: None)
    with pytest.raises(HitabError, match="cannot play again what it has played since cycle 0"):
        played.minute.go_back(5)
    assert played.world.snapshot() == present
    monkeypatch.undo()
    played.minute.go_back(5)


def test_a_world_whose_snapshot_fails_says_why_it_cannot_go_back(monkeypatch):
    played = Played()
    played.play(2)

    def fails() -> Any:
        raise KeyError("x")

    with monkeypatch.context() as broken:
        broken.setattr(played.world, "snapshot", fails)
        played.minute.cut()
        played.minute.note({})
        assert played.minute.oldest == 0
        with pytest.raises(HitabError, match="its snapshot fails: KeyError"):
            played.minute.go_back(1)
    played.play(2)
    assert played.minute.oldest == 2
