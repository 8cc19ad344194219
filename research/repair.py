"""Measures whether at most five corrections repair a team after its world has changed.

The shipped keepers, trained by the lessons, play in worlds with another ball, other takers, weaker
kicks or a sensor that is off. A punctual simulated person who knows the thresholds that are right
there (`search` finds them) resumes the saved behaviors, takes over, and commands at most five
times; each time that a correction takes to be learned is kept. The same person also trains
everything from nothing, with as many commands as needed and with five. All teams play the same
episodes. research/repair.md describes the method and the figures.

    scripts/python research/repair.py search
    scripts/python research/repair.py compare --resume repair.jsonl --json repair.json
    scripts/python research/repair.py inward
"""

from __future__ import annotations

import json as js
import math
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from statistics import fmean
from typing import Annotated, Any

import typer
from changed_worlds import CHANGES, NEARER, Change, adapted
from correcting import MOST, SHIPPED, corrected, retrained
from finished_runs import FinishedRuns, Resume
from intentions import INTENTIONS, TAKER, Edges
from repair_table import COMPLETE, table

from hitab_core import Automaton, BehaviorLibrary, Repertoire
from hitab_world.inprocess import perform, play
from keepaway_world.domain import DOMAIN

app = typer.Typer(add_completion=False, help=__doc__)
TOP = "Keepaway"
REPAIRED = "repaired by five corrections"
BLOCK, APART = 20, 10_000
"""Episodes between two entries of the file of finished runs; between two people's first ones."""

NEAR = (1.8, 2.5, 3.5, 4.5)
FASTER: Edges = {"GoSlow": 1.5, "GoMedium": 2.5}
"""What `search` tries: when to pass, m, and then whether to slow down later."""


@cache
def teams(name: str, seed: int) -> tuple[Mapping[str, Mapping[str, Automaton]], Mapping[str, Any]]:
    """Return the automata of each team after a change, and what their training took."""
    change = CHANGES[name]
    pupils = {
        REPAIRED: corrected(change, seed),
        "its automaton from nothing, five commands": corrected(change, seed, afresh=True),
        "all from nothing, five commands": retrained(change, seed, MOST),
        COMPLETE: retrained(change, seed),
    }
    made = {
        "untouched": BehaviorLibrary(SHIPPED, DOMAIN).load(),
        **{team: dict(pupil.repertoire.automata) for team, pupil in pupils.items()},
        "zero examples: rules as before": INTENTIONS["lessons"].automata(),
        "zero examples: rules for the change": change.intention.automata(),
    }
    took = {team: [round(1e3 * s, 1) for s in pupil.learning] for team, pupil in pupils.items()}
    for pupil in pupils.values():
        pupil.close()
    return made, took


def hold_times(
    change: Change, automata: Mapping[str, Automaton], seed: int, episodes: range
) -> list[float]:
    """Return for how long a team holds the ball, s; it stands idle if it cannot play."""
    world = change.world(change.parameters, seed)
    players = perform(world, Repertoire(DOMAIN, automata), TOP) if TOP in automata else {}
    return [p.seconds for p in play(world, players, len(episodes), first=episodes.start)]


def measured(name: str, person: int, block: int, seed: int) -> dict[str, Any]:
    """Return for how long the teams of a person hold the ball in some episodes.

    From the second block on only the two that the goal is about play.
    """
    change, first = CHANGES[name], person * APART + block * BLOCK
    made, took = teams(name, seed * 1000 + person)
    span = range(first, first + BLOCK)
    seconds = {
        team: hold_times(change, automata, seed + 7, span)
        for team, automata in made.items()
        if block == 0 or team in (REPAIRED, COMPLETE)
    }
    where = {"change": name, "world": repr(change), "person": person, "block": block}
    return {**where, "seconds": seconds, "learning_ms": took}


@app.command()
def compare(
    people: Annotated[int, typer.Option(help="How many people.", min=1)] = 10,
    episodes: Annotated[int, typer.Option(help="Of each person's teams.", min=2)] = 200,
    seed: Annotated[int, typer.Option(help="Seed of people and games.")] = 7731,
    only: Annotated[list[str] | None, typer.Option(help="Only these changes.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    resume: Resume = "",
) -> None:
    """Repair and retrain teams after each change, and have all play the same episodes.

    With more people or episodes, a file of finished runs goes on; Ctrl-C tells what is done.
    """
    finished = FinishedRuns(resume, {"seed": seed, "block": BLOCK})
    names = only or list(CHANGES)
    units = [
        (block, person, name)
        for block in range(math.ceil(episodes / BLOCK))
        for person in range(people)
        for name in names
    ]
    runs: list[dict[str, Any]] = []
    try:
        for block, person, name in units:
            unit = f"{name}, person {person}, block {block}"
            if finished.figures.get(unit, {}).get("world") != repr(CHANGES[name]):
                run = measured(name, person, block, seed)
                finished.add(unit, run)
                means = ", ".join(f"{fmean(s):.1f}" for s in run["seconds"].values())
                print(f"  {unit}: {means} s", flush=True)
            runs.append(finished.figures[unit])
    except KeyboardInterrupt:
        print("interrupted; these are the figures so far")
    told = {}
    for name in names:
        if found := [run for run in runs if run["change"] == name]:
            told[name] = table(name, found)
    if json:
        Path(json).write_text(js.dumps(told, indent=1) + "\n", "utf-8")


@app.command()
def search(
    episodes: Annotated[int, typer.Option(help="Of each team.", min=2)] = 100,
    seed: Annotated[int, typer.Option(help="Of the games; not that of `compare`.")] = 5,
) -> None:
    """Try other thresholds after each change, by rules."""
    for name, change in CHANGES.items():
        for more in ({}, FASTER):
            for near in NEAR:
                rules = adapted({"near": near, **more}).automata()
                held = fmean(hold_times(change, rules, seed, range(episodes)))
                print(f"{name}: pass at {near} m{', faster' if more else ''}: {held:.1f} s")


@app.command()
def inward(
    people: Annotated[int, typer.Option(help="How many people.", min=1)] = 10,
    seed: Annotated[int, typer.Option(help="Seed of people.")] = 8842,
) -> None:
    """Have people correct a keeper that should pass later; print from where on it passes."""
    for deletes in (False, True):
        for person in range(people):
            pupil = corrected(NEARER, seed + person, deletes=deletes)
            given, at = len(pupil.learning), passes_from(pupil.repertoire.automata["ControlBall"])
            told = "an outdated one deleted" if deletes else "nothing deleted"
            print(f"person {person}, {told}: {given} commands, passes from {at:.1f} m on")
            pupil.close()


def passes_from(automaton: Automaton) -> float:
    """Return the largest distance of a taker at which a keeper with the ball passes, m."""
    names = [str(feature) for feature in automaton.features]

    def passes(metres: float) -> bool:
        values = [metres if name == TAKER else 1.0 for name in names]
        odds = automaton.transitions["Stop"].explain(values, names).distribution
        return odds.get("Pass", 0.0) > 0.5

    return max((d / 10 for d in range(100) if passes(d / 10)), default=0.0)


if __name__ == "__main__":
    app()
