"""Measures how many agents one core ticks per second in a batch.

The agents perform the trained four-level Keepaway automaton on percepts recorded from games.
Reading the features from the percepts is counted, and so is drawing; what the basic behaviors
then do with the bodies is not. The same agents are ticked one by one for comparison, and the two
must decide the same.

    scripts/python research/batch.py --json batch.json
"""

from __future__ import annotations

import random
import time
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import numpy as np
import typer
from report import tell

from hitab_core.arrays import Floats
from hitab_core.domain import BatchPercepts
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_core.running.batch_automaton import BatchAutomaton, draws_of
from hitab_core.running.batch_senses import BatchSenses
from hitab_core.running.running_automaton import RunContext
from hitab_core.running.senses import Senses
from hitab_core.use import Use
from hitab_world.inprocess import cycle, perform
from keepaway_research.features_of_all import DOMAIN
from keepaway_world.body import KeeperBody
from keepaway_world.world import KeepawayWorld

KEEPAWAY = Use("Keepaway")
Cycle = tuple[Floats, dict[int, list[str]]]
"""What all agents perceive in one cycle: values, shape (n, m), and messages heard, by row."""


def record(repertoire: Repertoire, agents: int, cycles: int) -> list[Cycle]:
    """Return what many keepers perceive: each another keeper or another moment of some games."""
    world = KeepawayWorld(seed=11)
    players = perform(world, repertoire, "Keepaway")
    tracks: list[list[tuple[list[float], list[str]]]] = []
    while len(tracks) < min(agents, 60):
        world.reset()
        for player in players.values():
            player.begin(world.seed, world.episode)
        tracks += (found := [[] for _ in world.agents])
        while len(found[0]) < cycles:
            for track, name in zip(found, world.agents, strict=True):
                track.append(world.percept(name))
            if world.ended or cycle(world, players):
                world.reset()
    recorded = []
    for now in range(cycles):
        seen = [tracks[i % len(tracks)][(now + i // len(tracks)) % cycles] for i in range(agents)]
        heard = {row: said for row, (_, said) in enumerate(seen) if said}
        recorded.append((np.array([values for values, _ in seen]), heard))
    return recorded


class Together:
    """Agents that are ticked over arrays."""

    def __init__(self, repertoire: Repertoire, agents: int) -> None:
        self.percepts = BatchPercepts(np.zeros((agents, 0)))
        self.senses = BatchSenses(DOMAIN, agents, percepts=self.percepts)
        draw = draws_of([random.Random(i).random for i in range(agents)])
        self.batch = BatchAutomaton(repertoire, KEEPAWAY, self.senses, draw, agents)
        self.rows = np.arange(agents)
        self.batch.start(self.rows)

    def tick(self, percepts: Cycle) -> None:
        """Tick all agents on their percepts."""
        self.percepts.values, self.percepts.heard = percepts
        self.senses.forget()
        self.batch.tick(self.rows)


class OneByOne:
    """The same agents, ticked one by one; basic behaviors are not pulsed."""

    def __init__(self, repertoire: Repertoire, agents: int) -> None:
        self.bodies = [KeeperBody(f"keeper_{i}") for i in range(agents)]
        self.senses = [Senses(body, DOMAIN) for body in self.bodies]
        self.running: list[Any] = [
            RunContext(repertoire, body, senses, random.Random(i).random).perform(KEEPAWAY)
            for i, (body, senses) in enumerate(zip(self.bodies, self.senses, strict=True))
        ]
        for running in self.running:
            running.start()

    def tick(self, percepts: Cycle) -> float:
        """Tick all agents on their percepts; return the time without taking percepts in, s."""
        values, heard = percepts
        for row, (body, senses) in enumerate(zip(self.bodies, self.senses, strict=True)):
            body.sense(values[row].tolist(), heard.get(row, ()))
            senses.forget()
        began = time.perf_counter()
        for running in self.running:
            running.tick()
        return time.perf_counter() - began


def check_same(together: Together, one_by_one: OneByOne) -> None:
    """Refuse to report figures if the two ways decide differently."""
    for row, running in enumerate(one_by_one.running):
        if together.batch.active_path(row) != running.active_path:
            raise SystemExit(f"agent {row}: the two ways of ticking have decided differently")


def main(
    agents: Annotated[str, typer.Option(help="Numbers of agents.")] = "100,1000,10000",
    cycles: Annotated[int, typer.Option(help="Cycles in each measurement.")] = 100,
    turns: Annotated[int, typer.Option(help="How often each is measured.")] = 5,
    library: Annotated[Path | None, typer.Option(help="Folder of a trained library.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Measure agent-ticks per second of the Keepaway automaton."""
    from hitab_client.shipped import shipped

    trained = BehaviorLibrary(library or shipped("libraries", "keepaway"), DOMAIN)
    repertoire = Repertoire(DOMAIN, trained.load())
    figures: dict[str, Any] = {}
    for count in [int(text) for text in agents.split(",")]:
        recorded = record(repertoire, count, cycles)
        together = Together(repertoire, count)
        rates = []
        for _ in range(turns):
            began = time.perf_counter()
            for percepts in recorded:
                together.tick(percepts)
            rates.append(count * cycles / (time.perf_counter() - began))
        figures[f"{count}_agents_ticks_per_s"] = round(median(rates))
        figures[f"{count}_agents_ticks_per_s_best"] = round(max(rates))
        if count <= 1000:
            one_by_one = OneByOne(repertoire, count)
            times = [one_by_one.tick(percepts) for _ in range(turns) for percepts in recorded]
            check_same(together, one_by_one)
            figures[f"{count}_agents_one_by_one_ticks_per_s"] = round(count / median(times))
    tell(
        f"Agent-ticks per second of Keepaway on one core, medians of {turns} turns of "
        f"{cycles} cycles; features read from percepts",
        figures,
        json,
    )


if __name__ == "__main__":
    typer.run(main)
