"""Measures the effect of commanders: boxes that fifty foragers bring home, with and without.

    scripts/python research/foraging.py compare --json foraging.json --plot foraging.png
    scripts/python research/foraging.py search two_levels --resume search.jsonl

All run in one process with the trained libraries: the same foragers with the same behaviors on the
same fields, each for itself, without commanders but with the radio of a squad, in squads of five
under a commander, or in companies of five squads. `search` tries other waiting times.
"""

from __future__ import annotations

import json as json_module
import math
import os
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from statistics import mean, stdev
from typing import Annotated, Any

import typer
from finished_runs import FinishedRuns, Resume
from foraging_tasks import SCHOOL
from school import School
from scipy.stats import t as student_t
from tasks import lesson_file, library, scratch, terms

from foraging_world.domain import DOMAIN
from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_client.runs.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.inprocess import Commander, HierarchyPlayers, Member
from hitab_commander.kinds.kind import CommanderKind
from hitab_commander.kinds.kind_reader import KIND_FILE, read_kind
from hitab_core import Automaton, Domain, has
from hitab_core.learning import relearned
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_world.inprocess import play

app = typer.Typer(add_completion=False, help=__doc__)
SWARMS = {
    "flat": "each for itself",
    "radio": "each, with radio",
    "one_level": "commanders of 5",
    "two_levels": "commanders of 5 x 5",
}
FIELDS: dict[str, dict[str, Any]] = {
    "many": {"small_boxes": 30, "large_boxes": 0},
    "mixed": {"small_boxes": 6, "large_boxes": 3},
}
TITLES = {
    "many": "30 boxes for 5",
    "mixed": "6 boxes for 5, 3 for 25",
}
PLAYED = ("boxes", "small", "large")
SIZES = (*PLAYED, "work")
PAIRS = {
    "one_level_more_than_none": ("one_level", "flat", "one level more than none"),
    "two_levels_more_than_one": ("two_levels", "one_level", "two levels more than one"),
    "two_levels_more_than_none": ("two_levels", "flat", "two levels more than none"),
    "two_levels_more_than_radio": ("two_levels", "radio", "two levels more than radio"),
}
WAITING = {
    "flat": ("Forage", "Waited"),
    "radio": ("Together", "Waited"),
    "one_level": ("SquadForage", "LongestWait"),
    "two_levels": ("CompanyForage", "LongestWait"),
}
"""By swarm: the automaton and the feature that tell when a box is given up."""


def trained(name: str) -> tuple[CommanderKind, BehaviorLibrary]:
    """Return a kind of commander and what such commanders have learned."""
    folder = shipped("libraries", name)
    kind = read_kind(folder / KIND_FILE)
    return kind, BehaviorLibrary(folder, commander_domain(kind))


@cache
def foragers() -> dict[str, Automaton]:
    """Return what foragers have learned, with the lesson of those that only have the radio."""
    folder = scratch()
    automata = dict(BehaviorLibrary(shipped("libraries", "foraging"), DOMAIN).load())
    known = library(replace(DOMAIN, automata=automata), folder)
    world = ForagingWorld(SCHOOL, 1)
    school = School(
        world,
        HierarchyPlayers([Member(name, known) for name in world.agents]),
        terms("Sees(squad_box) Waited Rested"),
    )
    school.play(lesson_file("foraging_radio"))
    return {**automata, **school.learned("forager_1")}


def waiting(
    swarm: str, automata: Mapping[str, Automaton], domain: Domain, wait: float
) -> BehaviorLibrary:
    """Return a library in which a swarm was shown to give up after another time, s; 0: as it was.

    The examples stay the same, but for the time that had passed when giving up was shown.
    """
    name, feature = WAITING[swarm]
    if wait and name in automata:
        automaton = automata[name]
        column = [str(term) for term in automaton.features].index(feature)
        longest = max(example.features[column] for example in automaton.examples)
        examples = []
        for example in automaton.examples:
            seen = list(example.features)
            seen[column] = wait if seen[column] == longest else seen[column]
            examples.append(replace(example, features=tuple(seen)))
        changed = replace(automaton, examples=tuple(examples))
        automata = {**automata, name: relearned(changed, domain)}
    return library(replace(domain, automata=dict(automata)))


def hierarchy(swarm: str, names: Sequence[str], wait: float = 0.0) -> HierarchyPlayers:
    """Return foragers with these names, and the commanders of this kind of swarm.

    Args:
        wait: after which what the swarm cannot move is given up, s; 0: as the lessons taught.
    """
    behavior = "Together" if swarm == "radio" else "Forage"
    known = waiting(swarm, foragers(), DOMAIN, wait)
    members = [Member(name, known, behavior) for name in names]
    commanders: list[Commander] = []
    if swarm not in ("flat", "radio"):
        kind, squad_library = trained("foraging_squad")
        domain = commander_domain(kind)
        squad_library = waiting(swarm, squad_library.load(), domain, wait)
        behavior = "SquadForage" if swarm == "one_level" else ""
        commanders = [
            Commander(f"squad_{i + 1}", kind, squad_library, behavior, group)
            for i, group in enumerate(in_fives(names))
        ]
    if swarm == "two_levels":
        kind, company_library = trained("foraging_company")
        domain = commander_domain(kind)
        company_library = waiting(swarm, company_library.load(), domain, wait)
        squads = [commander.name for commander in commanders]
        commanders += [
            Commander(f"company_{i + 1}", kind, company_library, "CompanyForage", group)
            for i, group in enumerate(in_fives(squads))
        ]
    return HierarchyPlayers(members, commanders)


def in_fives(names: Sequence[str]) -> list[tuple[str, ...]]:
    """Return names in squads of five, or squads in companies."""
    return [tuple(names[i : i + 5]) for i in range(0, len(names), 5)]


def measure(seconds: float, run: tuple[str, str, int, float]) -> dict[str, float]:
    """Play one episode and return the boxes that came home, by size."""
    field, swarm, seed, wait = run
    world = ForagingWorld(ForagingParameters(duration=seconds, **FIELDS[field]), seed)
    made = hierarchy(swarm, world.agents, wait)
    (result,) = play(world, made.players, between=made.confer)
    return dict(result.measures)


def interval(values: Sequence[float]) -> dict[str, float]:
    """Return the mean and half of its 95% confidence interval."""
    half = (
        student_t.ppf(0.975, len(values) - 1) * stdev(values) / math.sqrt(len(values))
        if len(values) > 1
        else math.nan
    )
    return {"mean": mean(values), "ci95": half}


def compared(one: Sequence[float], other: Sequence[float]) -> dict[str, float]:
    """Return how much more ``one`` is, in pairs on the same fields."""
    return interval([a - b for a, b in zip(one, other, strict=True)])


def draw(figures: Mapping[str, Any], path: str) -> None:
    """Draw bars with confidence intervals, small and large boxes on top of each other."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    fields = figures["fields"]
    picture, grid = pyplot.subplots(
        1, len(fields), figsize=(3.6 * len(fields), 3.8), squeeze=False, layout="constrained"
    )
    axes = grid[0]
    for axis, (field, swarms) in zip(axes, fields.items(), strict=True):
        places = range(len(swarms))
        small = [s["small"]["mean"] for s in swarms.values()]
        large = [s["large"]["mean"] for s in swarms.values()]
        both = [s["boxes"]["mean"] for s in swarms.values()]
        axis.bar(places, small, color="#7aa6c2", label="for 5")
        axis.bar(places, large, bottom=small, color="#c2703d", label="for 25")
        errors = [s["boxes"]["ci95"] for s in swarms.values()]
        axis.errorbar(places, both, yerr=errors, fmt="none", ecolor="black", capsize=4)
        axis.set_xticks(
            list(places), [SWARMS[s].replace(" of ", "\nof ") for s in swarms], fontsize=8
        )
        axis.set_title(TITLES[field], fontsize=10)
        axis.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel(f"boxes brought home in {figures['seconds']:g} s")
    picture.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
    picture.savefig(path, dpi=110)


def summary(results: Mapping[str, Any]) -> dict[str, Any]:
    """Return the statistics of results: boxes by field, swarm and size, a number for each run."""
    found: dict[str, Any] = {**results, "fields": {}, **{name: {} for name in PAIRS}}
    for field, swarms in results["runs"].items():
        for sizes in swarms.values():
            sizes["work"] = [
                5 * small + 25 * large
                for small, large in zip(sizes["small"], sizes["large"], strict=True)
            ]
        found["fields"][field] = {
            swarm: {size: interval(sizes[size]) for size in SIZES}
            for swarm, sizes in swarms.items()
        }
        for what, (more, less, _) in PAIRS.items():
            if {more, less} <= {*swarms}:
                found[what][field] = {
                    size: compared(swarms[more][size], swarms[less][size]) for size in SIZES
                }
    return found


def play_all(
    plan: Mapping[str, tuple[str, str, int, float]],
    seconds: float,
    processes: int,
    finished: FinishedRuns,
) -> None:
    """Play all runs but those that have finished."""
    missing = {name: run for name, run in plan.items() if name not in finished.figures}
    with ProcessPoolExecutor(processes) as pool:
        playing = pool.map(partial(measure, seconds), missing.values())
        for count, (name, measures) in enumerate(zip(missing, playing, strict=True), 1):
            finished.add(name, measures)
            done = len(plan) - len(missing) + count
            print(f"\r{done} of {len(plan)} runs", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)


def chosen(names: Sequence[str] | None, known: Mapping[str, Any], what: str) -> list[str]:
    """Return the names that are given, or all.

    Raises:
        typer.BadParameter: if one is unknown.
    """
    if unknown := sorted({*(names or [])} - {*known}):
        raise typer.BadParameter(f"no {what} {', '.join(unknown)} {has(known, *unknown)}")
    return list(names or known)


Processes = Annotated[int, typer.Option(help="Parallel runs.")]
Seconds = Annotated[float, typer.Option(help="Length of a run, simulated s.")]
CORES = os.cpu_count() or 1


@app.command()
def search(
    swarm: Annotated[str, typer.Argument(help=f"One of: {', '.join(SWARMS)}.")],
    field: Annotated[str, typer.Option(help="Field to play on.")] = "mixed",
    wait: Annotated[
        list[float] | None, typer.Option(help="Waiting time to try, s; repeat for several.")
    ] = None,
    runs: Annotated[int, typer.Option(min=2, help="Runs with each waiting time.")] = 4,
    seconds: Seconds = 300.0,
    processes: Processes = CORES,
    first_seed: Annotated[int, typer.Option(help="Not one of `compare`.")] = 9001,
    resume: Resume = "",
) -> None:
    """Try other times after which a swarm gives up what it cannot move."""
    chosen([swarm], SWARMS, "swarm")
    chosen([field], FIELDS, "field")
    finished = FinishedRuns(resume, {"seconds": seconds})
    seeds = range(first_seed, first_seed + runs)
    waits = wait or (15.0, 30.0, 45.0, 60.0, 90.0, 120.0)
    plan = {
        f"{field}, {swarm}, {one:g} s, seed {seed}": (field, swarm, seed, one)
        for seed in seeds
        for one in waits
    }
    play_all(plan, seconds, processes, finished)
    for one in waits:
        played = [finished.figures[f"{field}, {swarm}, {one:g} s, seed {seed}"] for seed in seeds]
        work = interval([5 * boxes["small"] + 25 * boxes["large"] for boxes in played])
        boxes = interval([each["boxes"] for each in played])
        told = " ± ".join(f"{x:.1f}" for x in boxes.values())
        print(f"{one:6g} s: {told} boxes, {work['mean']:.1f} ± {work['ci95']:.1f} pullers")


@app.command()
def compare(
    runs: Annotated[int, typer.Option(min=2, help="Runs of each swarm on each field.")] = 30,
    seconds: Seconds = 300.0,
    fields: Annotated[
        list[str] | None,
        typer.Option("--field", help="Field to play on; repeat for several. All by default."),
    ] = None,
    swarms: Annotated[
        list[str] | None,
        typer.Option("--swarm", help="Kind of swarm; repeat for several. All by default."),
    ] = None,
    waits: Annotated[
        list[str] | None,
        typer.Option("--wait", help="Another waiting time of a swarm, s, such as flat=45."),
    ] = None,
    processes: Processes = CORES,
    first_seed: Annotated[int, typer.Option(help="Seed of the first run; counts up.")] = 1,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    read: Annotated[str, typer.Option(help="Play nothing; read this JSON file.")] = "",
    plot: Annotated[str, typer.Option(help="File for a plot, PNG or SVG.")] = "",
    resume: Resume = "",
) -> None:
    """Compare foragers without commanders, with one level and with two."""
    fields, swarms = chosen(fields, FIELDS, "field"), chosen(swarms, SWARMS, "swarm")
    given = dict.fromkeys(swarms, 0.0) | {
        swarm: float(wait) for swarm, _, wait in (text.partition("=") for text in waits or [])
    }
    chosen(list(given), SWARMS, "swarm")
    if read:
        results = json_module.loads(Path(read).read_text(encoding="utf-8"))
    else:
        finished = FinishedRuns(resume, {"seconds": seconds, "waits": given})
        seeds = range(first_seed, first_seed + runs)
        plan = {
            f"{field}, {swarm}, seed {seed}": (field, swarm, seed, given[swarm])
            for seed in seeds
            for field in fields
            for swarm in swarms
        }
        play_all(plan, seconds, processes, finished)
        results = {
            "seeds": list(seeds),
            "seconds": seconds,
            "runs": {
                field: {
                    swarm: {
                        size: [
                            finished.figures[f"{field}, {swarm}, seed {s}"][size] for s in seeds
                        ]
                        for size in PLAYED
                    }
                    for swarm in swarms
                }
                for field in fields
            },
        }
    figures = summary(results)
    report(figures)
    if json:
        Path(json).write_text(json_module.dumps(figures, indent=1) + "\n", encoding="utf-8")
    if plot:
        draw(figures, plot)


def report(figures: Mapping[str, Any]) -> None:
    """Print the figures as tables."""
    print(
        f"Boxes that 50 foragers brought home in {figures['seconds']:g} s, and the pullers that "
        f"these need: mean of {len(figures['seeds'])} runs and its 95% confidence interval"
    )
    heads = "".join(f"{head:>15}" for head in ("all", "for 5", "for 25", "pullers"))
    print(f"{'field':28}{'swarm':22}{heads}")
    for field, swarms in figures["fields"].items():
        for swarm, sizes in swarms.items():
            print(f"{TITLES[field]:28}{SWARMS[swarm]:22}{_told(sizes)}")
    for what, (_, _, swarm) in PAIRS.items():
        for field, sizes in figures[what].items():
            print(f"{TITLES[field]:24}{swarm:26}{_told(sizes)}")


def _told(sizes: Mapping[str, Mapping[str, float]]) -> str:
    return "".join(f"{sizes[s]['mean']:9.1f} ± {sizes[s]['ci95']:3.1f}" for s in SIZES)


if __name__ == "__main__":
    app()
