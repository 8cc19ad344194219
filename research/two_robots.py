"""Plays two trained robots under a captain in ir-sim; counts its collisions and what they reach.

Each seed has obstacles and start poses of its own. All runs in one process; with ``--topics`` the
robots, their captain and the simulator are processes instead, and talk over topics. Beside them:
the robots without their captain, and the same words with one rule for each behavior, and no
example. docs/irsim.md shows how to install ir-sim.

    python research/two_robots.py --seeds 20 --json irsim.json
"""

from __future__ import annotations

import json as json_module
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from two_robots_runs import ROBOTS, STEP, THERE, Outcome, Tell, play, play_over_topics, room

from hitab_client.measures import estimate
from hitab_core import unknown

TEAMS = {
    "trained": "trained",
    "alone": "no captain",
    "rules": "the same words, one-line rules",
}


def figures(runs: Sequence[dict[str, Outcome]]) -> dict[str, Any]:
    """Return what several runs amount to: means over the runs, with standard errors."""
    collided = [sum(o.collided is not None for o in run.values()) for run in runs]
    reached = [sum(len({*o.visits}) for o in run.values()) for run in runs]
    visits = [sum(len(o.visits) for o in run.values()) for run in runs]
    return {
        "runs": len(runs),
        "without_collision": sum(count == 0 for count in collided),
        "all_places": sum(count == len(ROBOTS) * len(room.WAYPOINTS) for count in reached),
        "collided_robots": asdict(estimate(collided)),
        "places": asdict(estimate(reached)),
        "visits": asdict(estimate(visits)),
    }


def table(results: dict[str, dict[str, Any]], minutes: float) -> Table:
    """Return the figures as a table."""
    shown = Table(title=f"two robots, {minutes:g} simulated minutes for each seed")
    for name in ("", "seeds", "no collision", "all places", "collided", "places of 8", "visits"):
        shown.add_column(name, justify="right" if name else "left")
    for which, row in results.items():
        means = [_with_error(row[name]) for name in ("collided_robots", "places", "visits")]
        counts = [str(row[name]) for name in ("runs", "without_collision", "all_places")]
        shown.add_row(TEAMS[which], *counts, *means)
    return shown


def _with_error(value: dict[str, float | None]) -> str:
    error = "" if value["se"] is None else f" ± {value['se']:.2f}"
    return f"{value['mean']:.2f}{error}"


def draw(outcomes: dict[str, Outcome], seed: int, path: Path) -> None:
    """Draw the room, the places and the ways of the robots."""
    from matplotlib import pyplot as plt
    from matplotlib.patches import Circle, Rectangle

    figure, axes = plt.subplots(figsize=(6.4, 5.0), layout="constrained")
    axes.set(
        xlim=(0.0, room.WIDTH),
        ylim=(0.0, room.HEIGHT),
        aspect="equal",
        xlabel="x, m",
        ylabel="y, m",
    )
    for obstacle in room.room(seed, len(ROBOTS), STEP)["obstacle"]:
        shape, (x, y, heading) = obstacle["shape"], obstacle["state"]
        if shape["name"] == "rectangle":
            size = shape["length"], shape["width"]
            corner = x - size[0] / 2.0, y - size[1] / 2.0
            angle = math.degrees(heading)
            axes.add_patch(
                Rectangle(corner, *size, angle=angle, rotation_point="center", color="0.4")
            )
    for (name, outcome), color in zip(outcomes.items(), ("tab:blue", "tab:red"), strict=True):
        axes.plot(*zip(*outcome.track, strict=True), color=color, linewidth=0.7, label=name)
        axes.add_patch(Circle(outcome.track[-1], room.HULL, color=color))
    for name, (x, y) in room.WAYPOINTS.items():
        axes.add_patch(Circle((x, y), THERE, fill=False, linestyle="--"))
        axes.annotate(name, (x, y), ha="center", va="center", weight="bold")
    axes.legend(loc="upper center", ncols=2)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main(
    seeds: Annotated[int, typer.Option(min=1, help="How many rooms.")] = 20,
    first: Annotated[int, typer.Option(help="The first seed.")] = 101,
    minutes: Annotated[float, typer.Option(min=0.1, help="Simulated time of a run.")] = 10.0,
    team: Annotated[
        list[str] | None, typer.Option(help=f"Which: {', '.join(TEAMS)}; by default all.")
    ] = None,
    topics: Annotated[
        bool, typer.Option("--topics", help="Play the trained team over topics, none else.")
    ] = False,
    yaw: Annotated[float, typer.Option(help="Which way the scanners face, degrees.")] = 0.0,
    json: Annotated[str, typer.Option(help="Write the figures to this file.")] = "",
    picture: Annotated[str, typer.Option(help="Draw the trained robots' first run here.")] = "",
) -> None:
    """Play runs, print what each comes to, and the table."""
    chosen = ["trained"] if topics else team or list(TEAMS)
    for name in chosen:
        if name not in TEAMS:
            raise typer.BadParameter(unknown("team", name, TEAMS))
    runs: dict[str, list[dict[str, Outcome]]] = {name: [] for name in chosen}
    for seed in range(first, first + seeds):
        for which, played in runs.items():
            tell = _progress(f"seed {seed}, {TEAMS[which]}", minutes * 60.0)
            if topics:
                outcomes = play_over_topics(seed, minutes * 60.0, math.radians(yaw), tell)
            else:
                outcomes = play(which, seed, minutes * 60.0, math.radians(yaw), tell)
            played.append(outcomes)
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
            print(_line(seed, which, outcomes), flush=True)
            if which == "trained" and seed == first and picture:
                draw(outcomes, seed, Path(picture))
        if json:  # what there is so far: runs take long
            written = _written(runs, first, minutes)
            Path(json).write_text(json_module.dumps(written, indent=2) + "\n", encoding="utf-8")
    Console().print(table({which: figures(played) for which, played in runs.items()}, minutes))


def _progress(title: str, seconds: float) -> Tell:
    def tell(now: float) -> None:
        print(
            f"\r\x1b[K{title}: {now:.0f} of {seconds:.0f} s", end="", file=sys.stderr, flush=True
        )

    return tell


def _line(seed: int, which: str, outcomes: dict[str, Outcome]) -> str:
    """Return one run in a line."""
    told = []
    for name, outcome in outcomes.items():
        hit = "" if outcome.collided is None else f", COLLIDED at {outcome.collided:.0f} s"
        told.append(f"{name} {len({*outcome.visits})} places, {len(outcome.visits)} visits{hit}")
    return f"seed {seed}, {TEAMS[which]}: {'; '.join(told)}"


def _written(
    runs: dict[str, list[dict[str, Outcome]]], first: int, minutes: float
) -> dict[str, Any]:
    return {
        "minutes": minutes,
        "figures": {which: figures(played) for which, played in runs.items()},
        "runs": {
            which: [
                {"seed": first + i}
                | {
                    name: {key: value for key, value in asdict(o).items() if key != "track"}
                    for name, o in run.items()
                }
                for i, run in enumerate(played)
            ]
            for which, played in runs.items()
        },
    }


if __name__ == "__main__":
    typer.run(main)
