"""Errors for a world that does not answer: reasons and remedies."""

import weakref
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import Episode, WorldState, WorldStatus
from hitab_msgs.srv import Control, Play

from hitab_client.errors import SwarmError
from hitab_client.rest import Rest
from hitab_client.runs.run_folder import RunRecord
from hitab_client.runs.run_processes import RunProcesses
from hitab_client.world_client import WorldClient
from hitab_ros.call import Caller, blocking


class Link(Caller):
    """A link to a world that answers; messages on the way arrive during waits.

    Args:
        answer: answer of the world's services; None without one.
        on_the_way: messages on the way.
        take: called with each message.
        seconds: time until each message arrives.
    """

    def __init__(
        self,
        answer: Any = None,
        on_the_way: Sequence[Any] = (),
        take: Callable[[Any], None] = print,
        seconds: float = 0.0,
    ) -> None:
        super().__init__(SimpleNamespace(count_publishers=lambda _: 1))
        self._answer, self._on_the_way = answer, list(on_the_way)
        self._take, self._seconds = take, seconds

    def subscribe(self, *arguments: Any, **options: Any) -> None:
        pass

    @blocking
    async def call(self, *_: Any, **__: Any) -> Any:
        return self._answer

    async def until(self, done: Callable[[], Any], seconds: float, *_: Any, **more: Any) -> bool:
        while not done() and seconds >= self._seconds and self._on_the_way:
            self._take(self._on_the_way.pop(0))
        return bool(done())


def record(tmp_path, *, world):
    socket = str(tmp_path / "none")
    return RunRecord(
        "gopher", "g.yaml", 7, "LOCALHOST", ("gopher_1",), world, 1, socket, "gopher-1", (), {}
    )


def why(processes, started_by_it):
    world = WorldClient(Link(), started_by_it=started_by_it, processes=processes)
    with pytest.raises(SwarmError) as refused:
        world.place({"gopher_1": {"x": 0.0}})
    return refused.value


def test_a_swarm_of_robots_is_not_advised_to_start_a_world(tmp_path):
    error = why(RunProcesses(record(tmp_path, world=False)), False)
    assert "this swarm has no world" in error.what
    assert error.remedies == ()


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
    link = Link(
        Control.Response(success=True, cycle=9),
        [was, now],
        lambda status: setattr(world, "status", status),
        1.0,
    )
    world = WorldClient(link)
    world.status, world.state = was, WorldState(cycle=9)
    drive(world)
    assert world.status == now


def test_an_episode_counts_as_first_told_though_a_restarted_world_repeats_it():
    reported = [(0, True), (1, True), (0, False), (1, False), (2, False)]
    on_the_way = [Episode(run=3, number=n, reproducible=r) for n, r in reported]
    answer = Play.Response(success=True, run=3)
    world = WorldClient(Link(answer, on_the_way, lambda episode: world.episodes.append(episode)))
    world.status, world.state = WorldStatus(), WorldState()
    played = world.play(3, 5)
    assert [(e.number, e.reproducible) for e in played] == [(0, True), (1, True), (2, False)]


class Status(SimpleNamespace):
    """A status to which there can be weak references."""


def test_who_waits_for_a_long_run_keeps_no_old_statuses():
    world: Any = SimpleNamespace(status=Status(mode="running"))
    rest = Rest(lambda: world.status)
    first = weakref.ref(world.status)
    for mode, is_resting in (("paused", False), ("running", False), ("paused", True)):
        world.status = Status(mode=mode, cycle=7, held="a: Go")
        assert bool(rest.look()) == is_resting, "the first new status may have been sent before"
    assert first() is None
    assert "rests at cycle 7: a: Go" in str(rest.error("it plays"))
