"""Playing in one process: timers follow the world's time."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from hitab_core import START, Automaton, BasicBehavior, Domain, HandWritten, Repertoire, Term
from hitab_world.inprocess import perform


def test_timers_count_the_worlds_seconds_anew_in_each_episode() -> None:
    domain = Domain.of(
        "still",
        "1",
        lambda name: SimpleNamespace(),
        behaviors=[BasicBehavior("Wait"), BasicBehavior("Go")],
        features=[],
    )
    waits = Automaton(
        "T",
        (Term("Wait"), Term("Go")),
        (Term("SecondsInState"),),
        {
            START: HandWritten(lambda: "Wait", ()),
            "Wait": HandWritten(lambda seconds: "Go" if seconds >= 0.5 else "Wait", (0,)),
        },
    )
    world: Any = SimpleNamespace(agents=["one"], episode_cycle=0, cycle_seconds=0.25)
    player: Any = perform(world, Repertoire(domain, {"T": waits}), "T")["one"]
    for _ in range(2):
        player.begin(1, 1)
        states = []
        for world.episode_cycle in range(4):
            player.tick()
            states.append(player.running.active)
        assert states == ["Wait", "Wait", "Go", "Go"]
        world.episode_cycle = 0
