"""Measures what a training costs as it grows: a command, and resuming it in another process.

A journal with a training of each size is written, and resumed as by an agent that was killed. The
agent is a keeper in a game; the journal keeps all that it could read around each command. Times
are of the processor, so they do not depend on the disk.

    scripts/python research/training_size.py --sizes 1000,3000,10000,30000 --json training.json
"""

from __future__ import annotations

import tempfile
import time
from itertools import cycle as in_turn
from pathlib import Path
from statistics import median
from typing import Annotated

import typer
from report import tell

from hitab_core.agent import Agent
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.training.curriculum import Curriculum
from hitab_core.use import Use
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld

LABELS = [Use(name) for name in ("GoFast", "TurnToBall", "GoSlow")]
FEATURES = tuple(map(Use.parse, ("DirectionTo(ball)", "DistanceTo(ball)")))
LAST = 100
"""The last commands, of which the median time is shown."""


def agent(folder: Path) -> Agent:
    """Return a keeper whose training is kept in a folder."""
    return Agent("keeper_1", DOMAIN, BehaviorLibrary(folder / "library", DOMAIN), folder)


def measure(size: int) -> dict[str, float]:
    """Return what a training with so many examples costs."""
    world = KeepawayWorld(seed=1)
    with tempfile.TemporaryDirectory(prefix="hitab-training-") as name:
        folder = Path(name)
        keeper = agent(folder)
        keeper.begin(Curriculum("Chase", FEATURES))
        session, labels, cycle = keeper.session, in_turn(LABELS), 0
        taken: list[float] = []
        assert session is not None
        while len(session.log) < size:
            cycle += 1
            if world.ended:
                world.reset()
            keeper.sense(*world.percept("keeper_1"), cycle, cycle * world.cycle_seconds)
            keeper.tick()
            world.step({"keeper_1": keeper.body.act()})
            began = time.process_time()
            keeper.command(next(labels))
            session.asked.count(session.log)
            taken.append(time.process_time() - began)
        keeper.journal.close()
        began = time.process_time()
        resumed = agent(folder)
        seconds = time.process_time() - began
        assert resumed.session is not None
        assert resumed.session.examples == session.examples
        resumed.journal.close()
    return {"command_ms": 1000 * median(taken[-LAST:]), "resume_s": seconds}


def main(
    sizes: Annotated[str, typer.Option(help="Numbers of examples.")] = "1000,3000,10000,30000",
    json: Annotated[str, typer.Option(help="File for the figures.")] = "",
) -> None:
    """Measure trainings of several sizes."""
    figures = {
        f"{size}_examples_{name}": value
        for size in map(int, sizes.split(","))
        for name, value in measure(size).items()
    }
    tell("What a training costs the processor: a command (ms), and resuming it (s)", figures, json)


if __name__ == "__main__":
    typer.run(main)
