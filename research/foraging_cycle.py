"""Measures what a cycle of the foraging world costs on one core, by the number of foragers.

scripts/python research/foraging_cycle.py --json foraging_cycle.json

A cycle includes the physics, and all foragers' percepts (as lists of floats) and actions. The
field grows with the number of foragers, and so do the obstacles and boxes on it.
"""

from __future__ import annotations

import math
import time
from random import Random
from statistics import median
from typing import Annotated, Any

import typer
from report import tell

from foraging_world.parameters import ForagingParameters
from foraging_world.world import ForagingWorld
from hitab_world.world import Action

SAMPLES = ([1.0, 0.0, 0.0], [1.0, 0.1, 0.0], [1.0, -0.1, 0.0], [1.0, 0.0, 1.0], [0.0, 0.2, -1.0])


def field_for(foragers: int) -> ForagingParameters:
    """Return a field with as much room and work per forager as the default has for fifty."""
    times = foragers / 50
    side = 60.0 * math.sqrt(times)
    return ForagingParameters(
        foragers=foragers,
        width=side,
        height=side,
        obstacles=round(8 * times),
        small_boxes=round(10 * times),
        large_boxes=round(2 * times),
    )


def cycle_ms(foragers: int, cycles: int) -> float:
    """Return the median CPU time of a cycle, ms."""
    world = ForagingWorld(field_for(foragers), seed=1)
    random = Random(1)
    plans: list[dict[str, Action]] = [
        {name: (random.choice(SAMPLES), "") for name in world.agents} for _ in range(10)
    ]
    times = []
    for cycle in range(cycles):
        began = time.process_time()
        for name in world.agents:
            world.percept(name)
        world.step(plans[cycle % len(plans)])
        times.append(time.process_time() - began)
    return 1000.0 * median(times)


def main(
    foragers: Annotated[str, typer.Option(help="Numbers of foragers.")] = "50,200,1000,2000",
    cycles: Annotated[int, typer.Option(help="Cycles with each number.")] = 100,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Measure the time of a cycle."""
    figures: dict[str, Any] = {
        f"ms_with_{count}": cycle_ms(int(count), cycles) for count in foragers.split(",")
    }
    tell("A cycle of the foraging world, ms of CPU time", figures, json)


if __name__ == "__main__":
    typer.run(main)
