"""Measures what one side of a circle is worth, and what questions add to it.

A command among default examples says where on a circle a change begins, not where it ends. Two
tasks in which both examples are equally far apart, but the ends are not: turning (a ball at 20 to
180 degrees) and docking (a dock within 20 degrees); and any arc, with its first end shown. Then
the agent asks about what it has met, and the person answers.

    scripts/python research/circle.py
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from random import Random
from statistics import fmean
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from hitab_core.advice.evidence import Evidence, answer_kind, on_circles
from hitab_core.advice.unshown import unshown
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import ExampleKind

CIRCLE = Scale(FeatureKind.TOROIDAL, 360.0)
GO, STAY = "Go", "Stay"
MET = 100
"""Situations that the agent has met when it asks, spread evenly over the circle."""

Arc = tuple[float, float, float]
"""Where a default example is, then the demonstrated one and the other end of what was meant."""

TASKS: dict[str, Arc] = {"turning": (10.0, 20.0, 180.0), "docking": (30.0, 20.0, -20.0)}


def meant(arc: Arc, place: float) -> str:
    """Return what the person means at a place."""
    default, first, last = arc
    start, end = (first, last) if (first - default) % 360 < 180 else (last, first)
    return GO if (place - start) % 360 <= (end - start) % 360 else STAY


def right(arc: Arc, evidence: Evidence) -> tuple[float, float]:
    """Return the fraction of the circle that was learned as meant, and the mean of both parts'."""
    places = np.arange(0.25, 360, 0.5)
    truth = np.array([meant(arc, place) for place in places.tolist()])
    tree = evidence.learn()
    assert tree is not None
    well = tree.predict(places[:, None]) == truth
    return float(well.mean()), fmean(float(well[truth == label].mean()) for label in (GO, STAY))


def taught(arc: Arc, questions: int, random: Random, classifier: str) -> list[Any]:
    """Return what is right after no, one, two, ... questions."""
    values = np.array([[arc[0] % 360], [arc[1] % 360]])
    default = np.array([True, False])
    evidence = Evidence(
        STAY, values, (STAY, GO), default, (CIRCLE,), ("DirectionTo(it)",), ("deg",), classifier
    )
    met = [(360 * (n + random.random()) / MET,) for n in range(MET)]
    found = [right(arc, evidence)]
    for _ in range(questions):
        assumed = np.array([True, *[False] * (len(evidence.next_states) - 1)])
        question = unshown(evidence, met, [GO], assumed)
        if question is not None:
            place = question.situation
            evidence = _with_answer(evidence, place, meant(arc, place[0]), question.bisects)
        found.append(right(arc, evidence))
    return found


def _with_answer(
    evidence: Evidence, place: Sequence[float], next_state: str, bisects: bool
) -> Evidence:
    """Return the evidence with one more example."""
    kind = answer_kind(evidence.state, next_state, bisects=bisects)
    return replace(
        evidence,
        values=np.vstack([evidence.values, on_circles(np.array([place]), evidence.scales)]),
        next_states=(*evidence.next_states, next_state),
        default=np.append(evidence.default, kind is ExampleKind.DEFAULT),
    )


def anything(random: Random) -> Arc:
    """Draw a place, a direction, a width and how far apart the examples are."""
    first, direction = random.uniform(0, 360), random.choice((1, -1))
    gap, width = random.uniform(2, 30), random.uniform(10, 300)
    return first - direction * gap, first, first + direction * width


def _always(arc: Arc) -> Callable[[Random], Arc]:
    return lambda _: arc


def main(
    questions: Annotated[int, typer.Option(help="How many are answered.")] = 3,
    arcs: Annotated[int, typer.Option(help="How many arcs are drawn.")] = 100,
    seed: Annotated[int, typer.Option(help="Of arcs and situations.")] = 57,
) -> None:
    """Tell what was learned right of an arc after the first two examples, and after questions."""
    table = Table("task", "classifier", *(f"{n} questions" for n in range(questions + 1)))
    drawn: dict[str, Callable[[Random], Arc]] = {
        **{name: _always(arc) for name, arc in TASKS.items()},
        "any arc": anything,
    }
    for name, draw in drawn.items():
        for classifier in ("tree", "tree(all_around=True)"):
            random = Random(seed)
            found = [taught(draw(random), questions, random, classifier) for _ in range(arcs)]
            table.add_row(name, classifier, *(_cell(after) for after in zip(*found, strict=True)))
    Console().print(table)


def _cell(found: Sequence[tuple[float, float]]) -> str:
    return f"{fmean(all_ for all_, _ in found):.2f} ({fmean(both for _, both in found):.2f})"


if __name__ == "__main__":
    typer.run(main)
