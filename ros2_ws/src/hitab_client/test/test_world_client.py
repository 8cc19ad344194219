"""A world that does not answer: why, and what to do about it."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import Episode, WorldState, WorldStatus
from hitab_msgs.srv import Control, Play

from hitab_client.errors import SwarmError
from hitab_client.run_folder import RunRecord
from hitab_client.run_processes import RunProcesses
from hitab_client.world_client import WorldClient

SILENCE = SimpleNamespace(subscribe=lambda *_: None, spin_until=lambda *_, **__: False, node=None)


def record(tmp_path, *, world):
    socket = str(tmp_path / "none")
    return RunRecord(
        "gopher", "g.yaml", 7, "LOCALHOST", ("gopher_1",), world, 1, socket, "gopher-1", (), {}
    )


def why(processes, started_by_it):
    world = WorldClient(SILENCE, started_by_it=started_by_it, processes=processes)
    with pytest.raises(SwarmError) as refused:
        world.place({"gopher_1": {"x": 0.0}})
    return refused.value


def test_a_swarm_of_robots_is_not_advised_to_start_a_world(tmp_path):
    told = why(RunProcesses(record(tmp_path, world=False)), False)
    assert "this swarm has no world" in told.what
    assert told.remedies == ()


class Slow:
    """A link to a world whose statuses come a second after its answers and states."""

    def __init__(self, answer: Control.Response, *statuses: WorldStatus) -> None:
        self.call = lambda *_, **__: answer
        self.on_the_way = list(statuses)

    def subscribe(self, *arguments: Any) -> None:
        pass

    def spin_until(self, done: Callable[[], Any], seconds: float, *_: Any, **more: Any) -> bool:
        while not done() and seconds >= 1.0 and self.on_the_way:
            self.world.status = self.on_the_way.pop(0)
        return bool(done())


@pytest.mark.parametrize(
    ("drive", "before", "after"),
    [
        (lambda world: world.control("pause"), ("running", 7, 1.0), ("paused", 7, 1.0)),
        (lambda world: world.control("resume"), ("paused", 7, 1.0), ("running", 7, 1.0)),
        (lambda world: world.control("pace", factor=2.0), ("paused", 7, 1.0), ("paused", 7, 2.0)),
        (lambda world: world.step(5), ("running", 7, 1.0), ("paused", 9, 1.0)),
    ],
    ids=["pause", "resume", "pace", "step"],
)
def test_who_has_driven_the_world_knows_whether_it_runs(drive, before, after):
    was, now = (
        WorldStatus(mode=mode, cycle=cycle, factor=factor)
        for mode, cycle, factor in (before, after)
    )
    link: Any = Slow(Control.Response(success=True, cycle=9), was, now)
    link.world = world = WorldClient(link)
    world.status, world.state = was, WorldState(cycle=9)
    drive(world)
    assert world.status == now


def test_an_episode_counts_as_first_told_though_a_restarted_world_repeats_it():
    told = [(0, True), (1, True), (0, False), (1, False), (2, False)]
    on_the_way = [Episode(run=3, number=n, reproducible=r) for n, r in told]

    def spin_until(done: Callable[[], Any], *_: Any, **more: Any) -> bool:
        while not done() and on_the_way:
            world.episodes.append(on_the_way.pop(0))
        return bool(done())

    node = SimpleNamespace(count_publishers=lambda _: 1)
    answer = Play.Response(success=True, run=3)
    link: Any = SimpleNamespace(
        subscribe=lambda *_: None, spin_until=spin_until, call=lambda *_, **__: answer, node=node
    )
    world = WorldClient(link)
    world.status, world.state = WorldStatus(), WorldState()
    played = world.play(3, 5)
    assert [(e.number, e.reproducible) for e in played] == [(0, True), (1, True), (2, False)]
