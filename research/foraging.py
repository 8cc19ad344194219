"""Measures the effect of commanders: boxes that fifty foragers bring home, with and without.

scripts/python research/foraging.py --json foraging.json --plot foraging.png

All run in one process with the trained libraries: the same foragers with the same behaviors on the
same fields, each for itself, in squads of five under a commander, or in companies of five squads.
"""

from __future__ import annotations

import json as json_module
import math
import os
import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from statistics import mean, stdev
from typing import Annotated, Any

import typer
from finished_runs import FinishedRuns, Resume
from hierarchy_players import Commander, HierarchyPlayers, Member
from scipy.stats import t as student_t

from foraging_world.domain import DOMAIN
from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_client.shipped import shipped
from hitab_commander.commander_domain import commander_domain
from hitab_commander.kind import CommanderKind
from hitab_commander.kind_reader import KIND_FILE, read_kind
from hitab_core import has
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_world.inprocess import play

SWARMS = {
    "flat": "each for itself",
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
BEHAVIOR = "Forage"


def trained(name: str) -> tuple[CommanderKind, BehaviorLibrary]:
    """Return a kind of commander and what such commanders have learned."""
    folder = shipped("libraries", name)
    kind = read_kind(folder / KIND_FILE)
    return kind, BehaviorLibrary(folder, commander_domain(kind))


def hierarchy(swarm: str, names: Sequence[str]) -> HierarchyPlayers:
    """Return foragers with these names, and the commanders of this kind of swarm."""
    library = BehaviorLibrary(shipped("libraries", "foraging"), DOMAIN)
    members = [Member(name, library, BEHAVIOR) for name in names]
    commanders: list[Commander] = []
    if swarm != "flat":
        kind, squad_library = trained("foraging_squad")
        behavior = "SquadForage" if swarm == "one_level" else ""
        commanders = [
            Commander(f"squad_{i + 1}", kind, squad_library, behavior, group)
            for i, group in enumerate(in_fives(names))
        ]
    if swarm == "two_levels":
        kind, company_library = trained("foraging_company")
        squads = [commander.name for commander in commanders]
        commanders += [
            Commander(f"company_{i + 1}", kind, company_library, "CompanyForage", group)
            for i, group in enumerate(in_fives(squads))
        ]
    return HierarchyPlayers(members, commanders)


def in_fives(names: Sequence[str]) -> list[tuple[str, ...]]:
    return [tuple(names[i : i + 5]) for i in range(0, len(names), 5)]


def measure(seconds: float, run: tuple[str, str, int]) -> dict[str, float]:
    """Play one episode and return the boxes that came home, by size."""
    field, swarm, seed = run
    world = ForagingWorld(ForagingParameters(duration=seconds, **FIELDS[field]), seed)
    made = hierarchy(swarm, world.agents)
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
    found: dict[str, Any] = {**results, "fields": {}, "two_levels_more_than_one": {}}
    found["one_level_more_than_none"] = {}
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
        for what, more, less in (
            ("one_level_more_than_none", "one_level", "flat"),
            ("two_levels_more_than_one", "two_levels", "one_level"),
        ):
            found[what][field] = {
                size: compared(swarms[more][size], swarms[less][size]) for size in SIZES
            }
    return found


def play_all(
    fields: Sequence[str],
    seeds: Sequence[int],
    seconds: float,
    processes: int,
    finished: FinishedRuns,
) -> dict[str, Any]:
    """Play all runs but those that have finished; return the results."""
    plan = {
        f"{field}, {swarm}, seed {seed}": (field, swarm, seed)
        for field in fields
        for swarm in SWARMS
        for seed in seeds
    }
    missing = {name: run for name, run in plan.items() if name not in finished.figures}
    with ProcessPoolExecutor(processes) as pool:
        playing = pool.map(partial(measure, seconds), missing.values())
        for count, (name, measures) in enumerate(zip(missing, playing, strict=True), 1):
            finished.add(name, measures)
            done = len(plan) - len(missing) + count
            print(f"\r{done} of {len(plan)} runs", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    played = {run: finished.figures[name] for name, run in plan.items()}
    return {
        "seeds": list(seeds),
        "seconds": seconds,
        "runs": {
            field: {
                swarm: {size: [played[field, swarm, s][size] for s in seeds] for size in PLAYED}
                for swarm in SWARMS
            }
            for field in fields
        },
    }


def main(
    runs: Annotated[int, typer.Option(min=2, help="Runs of each swarm on each field.")] = 30,
    seconds: Annotated[float, typer.Option(help="Length of a run, simulated s.")] = 300.0,
    fields: Annotated[
        list[str] | None,
        typer.Option("--field", help="Field to play on; repeat for several. All by default."),
    ] = None,
    processes: Annotated[int, typer.Option(help="Parallel runs.")] = os.cpu_count() or 1,
    first_seed: Annotated[int, typer.Option(help="Seed of the first run; counts up.")] = 1,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    read: Annotated[str, typer.Option(help="Play nothing; read this JSON file.")] = "",
    plot: Annotated[str, typer.Option(help="File for a plot, PNG or SVG.")] = "",
    resume: Resume = "",
) -> None:
    """Compare foragers without commanders, with one level and with two."""
    fields = fields or list(FIELDS)
    unknown = sorted({*fields} - {*FIELDS})
    if unknown:
        raise typer.BadParameter(f"no field {', '.join(unknown)} {has(FIELDS, *unknown)}")
    if read:
        results = json_module.loads(Path(read).read_text(encoding="utf-8"))
    else:
        finished = FinishedRuns(resume, {"seconds": seconds})
        seeds = range(first_seed, first_seed + runs)
        results = play_all(fields, seeds, seconds, processes, finished)
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
    for what, swarm in (
        ("one_level_more_than_none", "one level more than none"),
        ("two_levels_more_than_one", "two levels more than one"),
    ):
        for field, sizes in figures[what].items():
            print(f"{TITLES[field]:24}{swarm:26}{_told(sizes)}")


def _told(sizes: Mapping[str, Mapping[str, float]]) -> str:
    return "".join(f"{sizes[s]['mean']:9.1f} ± {sizes[s]['ci95']:3.1f}" for s in SIZES)


if __name__ == "__main__":
    typer.run(main)
