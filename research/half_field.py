"""Compares attackers in roles with others in half-field attack, over the same episodes.

What the shipped lessons have taught plays in one process with its captain, without it, and as
one role for all, learned from the same commands. Beside them play rules without any example: the
three roles by hand, with numbers that `search` found, the same with words swapped, and the
rule-based and random attackers that were there before the lessons. research/half_field.md has the
figures.

    scripts/python research/half_field.py compare --resume half_field.jsonl --json half_field.json
    scripts/python research/half_field.py search
"""

from __future__ import annotations

import json as js
import math
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from statistics import fmean, stdev
from typing import Annotated, Any

import typer
from finished_runs import FinishedRuns, Resume
from half_field_attackers import RULE_BASED, RandomAttacker
from half_field_rules import DEFAULT, SWAPS, Numbers, rules

from half_field_world.domain import DOMAIN
from half_field_world.game import half_field
from half_field_world.parameters import HalfFieldParameters
from hitab_client.runs.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_commander.kinds.kind_reader import KIND_FILE, read_kind
from hitab_core import Automaton, BehaviorLibrary, Example, Repertoire, Term
from hitab_core.learning import relearned
from hitab_core.training.exchange import exchanged
from hitab_world import EpisodeResult, World
from hitab_world.inprocess import AutomatonPlayer, perform, play

app = typer.Typer(add_completion=False, help=__doc__)
ROLES = ("Playmaker", "Winger", "Striker")
BLOCK = 20
ROLES_TEAM, ONE_ROLE = "roles with captain", "one role, the same commands"
Automata = Mapping[str, Automaton]
Team = Callable[[World], "tuple[Mapping[str, Any], Callable[[], None] | None]"]
"""Makes the players of a world, and what happens between perceiving and acting."""


def trained() -> dict[str, Automaton]:
    """Return what the lessons have taught the attackers."""
    return dict(BehaviorLibrary(shipped("libraries", "half_field"), DOMAIN).load())


def captained(automata: Automata) -> Team:
    """Return attackers whom the trained captain gives their roles."""
    folder = shipped("libraries", "half_field_captain")
    kind = read_kind(folder / KIND_FILE)
    domain = replace(DOMAIN, automata={**DOMAIN.automata, **automata})
    empty = tempfile.TemporaryDirectory()  # gone with the team

    def team(world: World) -> tuple[Mapping[str, Any], Callable[[], None]]:
        library = BehaviorLibrary(folder, commander_domain(kind))
        roles = {name: name for name in world.agents}
        players = HierarchyPlayers(
            [Member(name, BehaviorLibrary(empty.name, domain)) for name in world.agents],
            [Commander("captain", kind, library, "Captain", tuple(world.agents), roles)],
        )
        return players.players, players.confer

    return team


def fixed(automata: Automata) -> Team:
    """Return attackers that keep the roles that they begin with."""

    def team(world: World) -> tuple[Mapping[str, Any], None]:
        repertoire = Repertoire(DOMAIN, automata)
        pairs = zip(world.agents, ROLES, strict=True)
        return {n: AutomatonPlayer(repertoire, Term(role), n) for n, role in pairs}, None

    return team


def alike(automata: Automata, behavior: str) -> Team:
    """Return attackers that all perform the same."""
    return lambda world: (perform(world, Repertoire(DOMAIN, automata), behavior), None)


def one_role(automata: Automata) -> Automaton:
    """Return what all commands for the roles teach as one behavior, from all their features."""
    parts = [automata[role] for role in ROLES]
    features = tuple(
        dict.fromkeys(term for part in parts for term in (*part.chosen, *part.features))
    )
    states = tuple(dict.fromkeys(term for part in parts for term in part.states))
    examples: list[Example] = []
    for part in parts:
        examples += exchanged(part.examples, part.features, features, part.readable, part.name)
    numbered = [replace(e, number=i + 1, readings=()) for i, e in enumerate(examples)]
    return relearned(Automaton("Attacker", states, features, {}, examples=tuple(numbered)), DOMAIN)


def teams() -> dict[str, Team]:
    """Return all teams, by name."""
    learned = trained()
    swaps = {f"rules, {a} and {b} swapped": captained(rules(DEFAULT, (a, b))) for a, b in SWAPS}
    return {
        ROLES_TEAM: captained(learned),
        "roles without captain": fixed(learned),
        ONE_ROLE: alike({**learned, "Attacker": one_role(learned)}, "Attacker"),
        "playmakers only": alike(learned, "Playmaker"),
        "rules for roles, with captain": captained(rules()),
        "rules for roles, without captain": fixed(rules()),
        **swaps,
        "rule-based, before the lessons": alike({"RuleBased": RULE_BASED}, "RuleBased"),
        "random": lambda world: ({name: RandomAttacker(name) for name in world.agents}, None),
    }


def played(team: Team, seed: int, episodes: range, offside: bool) -> list[EpisodeResult]:
    """Play some episodes with a team."""
    return play_with(team, half_field(HalfFieldParameters(offside=offside), seed), episodes)


def play_with(team: Team, world: World, episodes: range) -> list[EpisodeResult]:
    """Play some episodes of a world with a team."""
    players, between = team(world)
    return play(world, players, len(episodes), first=episodes.start, between=between)


def goals_of(results: Sequence[EpisodeResult]) -> float:
    """Return the fraction of episodes that ended in a goal."""
    return fmean(r.measures["goals"] for r in results)


@app.command()
def compare(
    episodes: Annotated[int, typer.Option(help="Of each team.", min=2)] = 200,
    seed: Annotated[int, typer.Option(help="Of the games.")] = 80_217,
    offside: Annotated[bool, typer.Option(help="With offside.")] = False,
    only: Annotated[list[str] | None, typer.Option(help="Only these teams.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    resume: Resume = "",
) -> None:
    """Have all teams play the same episodes."""
    finished = FinishedRuns(resume, {"seed": seed, "block": BLOCK, "offside": offside})
    tell_teams(
        lambda team, block: played(team, seed, block, offside), episodes, only, finished, json
    )


def tell_teams(
    play: Callable[[Team, range], list[EpisodeResult]],
    episodes: int,
    only: Sequence[str] | None,
    finished: FinishedRuns,
    json: str,
) -> None:
    """Have teams play the same episodes, block by block; print and write how they did."""
    figures: dict[str, Any] = {}
    for name, team in teams().items():
        if only and name not in only:
            continue
        runs = []
        for first in range(0, episodes, BLOCK):
            unit = f"{name}, {first}"
            if unit not in finished.figures:
                results = play(team, range(first, first + BLOCK))
                finished.add(unit, [[r.ended, r.seconds, r.measures["passes"]] for r in results])
            runs += finished.figures[unit]
        figures[name] = told(name, runs[:episodes], figures)
    if json:
        Path(json).write_text(js.dumps(figures, indent=1) + "\n", "utf-8")


def told(name: str, runs: Sequence[Any], before: Mapping[str, Any]) -> dict[str, Any]:
    """Print how a team did, and by how much it differs from the first one; return the figures."""
    goals = [float(ended == "goal") for ended, _, _ in runs]
    ended = Counter(end for end, _, _ in runs)
    one: dict[str, Any] = {
        "goals": goals,
        "percent": 100.0 * fmean(goals),
        "se": 100.0 * stdev(goals) / math.sqrt(len(goals)),
        "ended": ended,
        "passes": fmean(passes for _, _, passes in runs),
        "seconds": fmean(seconds for _, seconds, _ in runs),
    }
    paired = ""
    if ROLES_TEAM in before:
        ahead = [a - b for a, b in zip(before[ROLES_TEAM]["goals"], goals, strict=True)]
        one["behind"], one["behind_se"] = (
            100.0 * fmean(ahead),
            100.0 * stdev(ahead) / math.sqrt(len(ahead)),
        )
        paired = f", {one['behind']:5.1f} ± {one['behind_se']:.1f} behind the roles"
    print(
        f"{name:50} {one['percent']:5.1f} ± {one['se']:.1f} % goals, {one['passes']:.2f} passes, "
        f"{one['seconds']:4.1f} s, {dict(ended)}{paired}",
        flush=True,
    )
    return one


@app.command()
def search(
    episodes: Annotated[int, typer.Option(help="Of each choice.", min=2)] = 100,
    seed: Annotated[int, typer.Option(help="Of the games; not that of `compare`.")] = 5,
) -> None:
    """Try other numbers for the rules."""
    choices = product((2.5, 4.0, 5.5), (-5.5, -4.0, -2.5, -1.0, 0.5), (18.0,), (0.0,), (7.0, 12.0))
    try_numbers(lambda team: played(team, seed, range(episodes), False), choices)


def try_numbers(
    play: Callable[[Team], list[EpisodeResult]], choices: Iterable[Sequence[float]]
) -> None:
    """Have the rules with captain play with each choice of their numbers; print how they did."""
    for numbers in (Numbers(*choice) for choice in choices):
        results = play(captained(rules(numbers)))
        ended = dict(Counter(result.ended for result in results))
        print(f"{100.0 * goals_of(results):5.1f} % goals: {numbers}, {ended}", flush=True)


if __name__ == "__main__":
    app()
