"""Measures what a team of hard-coded automata loses without one of them, and regains by training.

Three teams of keepers play the same number of episodes: the whole hard-coded team, which nobody
has taught anything; the team without one automaton; and the team with what was trained instead.

    scripts/python research/deleted_behavior.py --episodes 1000 --json deleted.json
    scripts/python research/deleted_behavior.py --library my_library
"""

from __future__ import annotations

import json as js
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean, stdev
from typing import Annotated, Any

import typer

from hitab_bringup import open_library
from hitab_client.shipped import shipped
from hitab_core import Automaton, Domain, Repertoire, load_domain
from hitab_core.library import parts_of
from hitab_world import EpisodeResult
from hitab_world.inprocess import perform, play
from keepaway_world.parameters import PAPER
from keepaway_world.world import KeepawayWorld

DOMAIN = "keepaway_handcoded"
BEHAVIOR = "Keepaway"
CHUNK = 10
"""Episodes between two lines of progress."""


@dataclass(frozen=True)
class Team:
    """What three keepers perform.

    Attributes:
        title: for the table.
        repertoire: with the behavior that they perform.
        examples: what was taught, default examples included.
    """

    title: str
    repertoire: Repertoire
    examples: int = 0


def teams(domain: Domain, deleted: str, trained: Mapping[str, Automaton]) -> list[Team]:
    """Return the three teams.

    Args:
        domain: with the hard-coded automata.
        deleted: name of the one that is taken out.
        trained: what was trained in its place, and what that is made of, by name.
    """
    rest = domain.without([deleted])
    examples = sum(len(automaton.examples) for automaton in trained.values())
    return [
        Team("hard-coded", Repertoire(domain)),
        Team(f"without {deleted}", Repertoire(rest)),
        Team(f"with the trained {deleted}", Repertoire(rest, trained), examples),
    ]


def played(
    team: Team, episodes: int, seed: int, speed: float, longest: float
) -> list[EpisodeResult]:
    """Play some episodes; longer ones than ``longest`` seconds are cut off."""
    world = KeepawayWorld(replace(PAPER, taker_speed=speed), seed)
    players = perform(world, team.repertoire, BEHAVIOR)
    cycles = round(longest / world.cycle_seconds)
    results: list[EpisodeResult] = []
    while len(results) < episodes:
        print(f"\r{team.title}: {len(results)} of {episodes}", end="", file=sys.stderr, flush=True)
        some = min(CHUNK, episodes - len(results))
        results += play(world, players, some, first=len(results), cycles_max=cycles)
    print(f"\r{' ' * 60}\r", end="", file=sys.stderr, flush=True)
    return results


def mean_and_error(values: Sequence[float]) -> tuple[float, float]:
    """Return the mean and its standard error."""
    return fmean(values), stdev(values) / math.sqrt(len(values))


def figures_of(team: Team, results: Sequence[EpisodeResult]) -> dict[str, Any]:
    """Return the figures of a team as plain data."""
    hold, hold_se = mean_and_error([result.seconds for result in results])
    passes, passes_se = mean_and_error([result.measures["passes"] for result in results])
    return {
        "team": team.title,
        "examples": team.examples,
        "hold_time_s": {"mean": round(hold, 3), "se": round(hold_se, 3)},
        "passes": {"mean": round(passes, 3), "se": round(passes_se, 3)},
        "cut_off": sum(not result.ended for result in results),
    }


def main(
    library: Annotated[
        Path | None,
        typer.Option("--library", "-l", help="A folder with what was trained; default: shipped."),
    ] = None,
    without: Annotated[
        str, typer.Option(help="The hard-coded automaton to take out.")
    ] = "GotoBall",
    episodes: Annotated[int, typer.Option(help="Episodes of each team.", min=2)] = 200,
    seed: Annotated[int, typer.Option(help="Seed of the episodes.", min=0)] = 2011,
    taker_speed: Annotated[
        float, typer.Option(help="Speed of the takers, as a fraction of full speed.", min=0.0)
    ] = 0.25,
    longest: Annotated[float, typer.Option(help="Cut longer episodes off, s.", min=1.0)] = 3600.0,
    json: Annotated[Path | None, typer.Option(help="JSON file for the figures.")] = None,
) -> None:
    """Measure a hard-coded team: whole, without one automaton, and with a trained one instead."""
    domain = load_domain(DOMAIN)
    opened = open_library(library or shipped("libraries", DOMAIN))
    learned = opened.load()
    if opened.domain.name != DOMAIN or without not in learned:
        raise typer.BadParameter(
            f'{opened.folder} has no "{without}" that was trained in the domain {DOMAIN}'
        )
    trained = {name: learned[name] for name in parts_of(opened.files, [without])}
    rows = []
    print(f"{episodes} episodes of each team, takers at {taker_speed:g} of their speed")
    print(f"  {'team':26} {'examples':>8}   {'hold time':>15}   {'passes':>12}")
    for team in teams(domain, without, trained):
        row = figures_of(team, played(team, episodes, seed, taker_speed, longest))
        rows.append(row)
        hold, passes = row["hold_time_s"], row["passes"]
        print(
            f"  {team.title:26} {team.examples:8}   {hold['mean']:6.2f} ± {hold['se']:4.2f} s"
            f"   {passes['mean']:5.2f} ± {passes['se']:4.2f}"
        )
    whole, _, taught = (row["hold_time_s"] for row in rows)
    difference, error = taught["mean"] - whole["mean"], math.hypot(taught["se"], whole["se"])
    print(f"  trained - hard-coded: {difference:+.2f} ± {error:.2f} s")
    if json is not None:
        text = js.dumps({"episodes": episodes, "seed": seed, "teams": rows}, indent=2)
        json.write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
