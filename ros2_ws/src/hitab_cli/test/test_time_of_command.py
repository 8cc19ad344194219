"""Time at which a command of the command line was due."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from hitab_cli.verbs.perform import commanding_verbs as commanding
from hitab_cli.verbs.verb_connection import Connection

RUNNING = SimpleNamespace(mode="running", pace="realtime", factor=2.0, taught=False)
PAUSED = SimpleNamespace(mode="paused", pace="realtime", factor=1.0)


class World:
    """A world that is found only once its agents are."""

    speed = 1.0

    def __init__(self, status: Any) -> None:
        self._found = status
        self._discovered = False
        self.status: Any = None

    def await_agent(self, agent: str) -> None:
        self._discovered = self._found is not None

    def is_there(self) -> bool:
        return self._discovered

    def wait(self) -> Any:
        self.status = self._found
        return self.status


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> None:
    """The person pressed Enter 1.5 s ago."""
    monkeypatch.setattr("time.time", lambda: 101.5)
    monkeypatch.setattr("psutil.Process.create_time", lambda self: 100.0)


@pytest.mark.usefixtures("started")
@pytest.mark.parametrize("by_hand", [False, True])
@pytest.mark.parametrize(("status", "due"), [(RUNNING, 3.6), (PAUSED, 0.0)])
def test_a_command_counts_from_enter_by_the_pace_of_the_world(
    status: Any, due: float, by_hand: bool
) -> None:
    """The world goes on while this process starts and searches for the agent."""
    world: Any = World(status)
    record: Any = None if by_hand else SimpleNamespace(world=True)
    swarm = Connection(world, world, world, world, record=record)
    assert commanding._passed(swarm, "ann", 0.3) == pytest.approx(due)


@pytest.mark.usefixtures("started")
def test_without_a_world_it_is_the_persons_own_time() -> None:
    world: Any = World(None)
    swarm = Connection(world, world, world, world)
    assert commanding._passed(swarm, "ann", 0.3) == pytest.approx(1.8)
