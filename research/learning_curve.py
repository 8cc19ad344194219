"""Measures how long keepers keep the ball after their first n examples.

For the paper's set of automata and for that of keepers that look ahead, at a quarter of the
takers' speed and at full speed. The examples are those of the shipped libraries, in the order in
which the lessons gave them. After each command (and the default example that comes with it) the
automata are relearned from the examples so far, and all keepers perform the highest one that
can be performed, that is, has an example that leaves Start.

    scripts/python research/learning_curve.py --episodes 200 --json curve.json --plot curve.png
    scripts/python research/learning_curve.py --again curve.json --plot curve.png
"""

from __future__ import annotations

import json as js
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import fmean, stdev
from typing import Annotated, Any

import typer

from hitab_bringup.libraries.opened_library import open_library
from hitab_cli.views.plots import figure, save
from hitab_client.runs.shipped import shipped
from hitab_core.automaton import FLAGS, START, Automaton
from hitab_core.domain import Domain, FeatureKind, Scale
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.repertoire import Repertoire
from hitab_world.inprocess import perform, play
from keepaway_world.parameters import PAPER
from keepaway_world.world import KeepawayWorld

SPEEDS = {"quarter": 0.25, "full": 1.0}
UT_HAND_S = {"quarter": 53.5, "full": 18.3}
"""Mean hold time of UT Austin's hand-coded keepers on the real simulator, s."""


@dataclass(frozen=True)
class Course:
    """A library and the order in which its automata were taught."""

    title: str
    library: str
    order: tuple[str, ...]
    color: str


COURSES = {
    "paper": Course(
        "the paper's automata",
        "keepaway",
        ("ApproachBall", "GotoBall", "ControlBall", "Keepaway"),
        "#c44e52",
    ),
    "predictive": Course(
        "keepers that look ahead",
        "keepaway_predictive",
        ("TakeBall", "PassBall", "PlayBall", "Keepaway"),
        "#1f5fb4",
    ),
}


def learned(automaton: Automaton, domain: Domain, count: int) -> Automaton:
    """Return an automaton as it is learned from its first examples."""
    examples = automaton.examples[:count]
    scales = [
        Scale(FeatureKind.BOOLEAN) if feature.name in FLAGS else domain.scale_of(feature)
        for feature in automaton.features
    ]
    return replace(automaton, examples=examples, transitions=learn_transitions(examples, scales))


def stages(
    automata: Sequence[Automaton], domain: Domain
) -> Iterator[tuple[int, str, dict[str, Automaton]]]:
    """After each command, yield the number of examples and what can be performed by then."""
    known: dict[str, Automaton] = {}
    before = 0
    for automaton in automata:
        commands = [example.command for example in automaton.examples]
        for count in range(1, len(commands) + 1):
            if count < len(commands) and commands[count] == commands[count - 1]:
                continue  # its default example comes next
            so_far = learned(automaton, domain, count)
            if START in so_far.transitions:
                known = {**known, automaton.name: so_far}
                yield before + count, automaton.name, known
        before += len(commands)


def hold_times(
    repertoire: Repertoire, behavior: str, speed: float, episodes: int, seed: int, longest: float
) -> list[float]:
    """Return the lengths of some episodes, s; longer ones are cut off."""
    world = KeepawayWorld(replace(PAPER, taker_speed=speed), seed)
    cycles = round(longest / world.cycle_seconds)
    players = perform(world, repertoire, behavior)
    return [p.seconds for p in play(world, players, episodes, first=0, cycles_max=cycles)]


def curve(
    course: Course, speed: float, episodes: int, seed: int, every: int, longest: float
) -> list[dict[str, Any]]:
    """Return the points of one learning curve."""
    opened = open_library(shipped("libraries", course.library))
    loaded = opened.load()
    all_stages = list(stages([loaded[name] for name in course.order], opened.domain))
    last_of = {name: count for count, name, _ in all_stages}
    points = []
    for index, (count, name, automata) in enumerate(all_stages):
        top = name == course.order[-1]
        if not top and index % every and count != last_of[name]:
            continue
        repertoire = Repertoire(opened.domain, automata)
        times = hold_times(repertoire, name, speed, episodes, seed, longest)
        mean, error = fmean(times), stdev(times) / len(times) ** 0.5
        points.append(
            {
                "examples": count,
                "behavior": name,
                "hold_time_s": {"mean": round(mean, 3), "se": round(error, 3)},
                "broken_off": sum(t >= longest for t in times),
            }
        )
        print(f"  {count:3} examples  {name:12} {mean:7.2f} ± {error:.2f} s", flush=True)
    return points


def draw(figures: dict[str, Any], path: Path) -> None:
    """Draw the curves, one pair of axes for each speed of the takers."""
    drawing, axes = figure(10.0, 4.2)
    grid = drawing.add_gridspec(1, 2)
    axes.remove()
    for column, (speed, factor) in enumerate(SPEEDS.items()):
        axes = drawing.add_subplot(grid[0, column])
        for key, course in COURSES.items():
            points = figures["curves"][key][speed]
            axes.errorbar(
                [point["examples"] for point in points],
                [point["hold_time_s"]["mean"] for point in points],
                yerr=[point["hold_time_s"]["se"] for point in points],
                color=course.color,
                marker="o",
                markersize=3,
                capsize=2,
                linewidth=1.2,
                label=course.title,
            )
        axes.axhline(
            UT_HAND_S[speed],
            color="black",
            linestyle="--",
            linewidth=1.0,
            label=f"UT hand, real simulator: {UT_HAND_S[speed]:g} s",
        )
        axes.set_yscale("log")
        axes.set_ylim(1.5, 2000.0)
        axes.set_xlabel("examples, default ones counted")
        axes.set_ylabel("hold time, s (log scale)")
        axes.set_title(f"takers at {factor:g} of full speed", fontsize=10)
        axes.grid(alpha=0.3, which="both", linewidth=0.4)
        axes.legend(fontsize=8, loc="upper left")
    save(drawing, path)


def main(
    episodes: Annotated[int, typer.Option(help="Episodes for each point.", min=2)] = 200,
    every: Annotated[
        int, typer.Option(help="Commands between two points, before the top level.", min=1)
    ] = 1,
    seed: Annotated[int, typer.Option(help="Seed of the episodes.")] = 2026,
    longest: Annotated[float, typer.Option(help="Cut longer episodes off, s.")] = 3600.0,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
    plot: Annotated[str, typer.Option(help="File for a plot, PNG or SVG.")] = "",
    again: Annotated[str, typer.Option(help="Play nothing; read this JSON file.")] = "",
) -> None:
    """Measure hold time against the number of examples, and draw it."""
    if again:
        figures = js.loads(Path(again).read_text(encoding="utf-8"))
    else:
        began = time.monotonic()
        curves: dict[str, Any] = {}
        for key, course in COURSES.items():
            curves[key] = {}
            for speed, factor in SPEEDS.items():
                print(f"{course.title}, takers at {factor:g} of full speed")
                curves[key][speed] = curve(course, factor, episodes, seed, every, longest)
        figures = {
            "episodes": episodes,
            "seed": seed,
            "longest_s": longest,
            "ut_hand_s": UT_HAND_S,
            "curves": curves,
            "wall_s": round(time.monotonic() - began, 1),
        }
    if json:
        Path(json).write_text(js.dumps(figures, indent=2) + "\n", encoding="utf-8")
    if plot:
        draw(figures, Path(plot))


if __name__ == "__main__":
    typer.run(main)
