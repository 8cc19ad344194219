"""Measures what a tree of commanders costs in lockstep.

Fifty foragers in one process play alone, and under ten squads and two companies in a second
process: in turns, the same field, the same number of cycles.

    scripts/python research/lockstep_hierarchy.py --cycles 300 --json hierarchy.json
"""

from __future__ import annotations

import time
from statistics import median
from typing import Annotated

import typer
from report import tell

SWARMS = {"alone": "foraging", "commanded": "foraging_two_levels"}
AT_ONCE = 50  # cycles


def rate(name: str, cycles: int, seed: int) -> tuple[float, int]:
    """Return the cycles per second of a shipped swarm in lockstep, and the deadlines missed."""
    from hitab_bringup.processes.bringing_up import temporary_swarm
    from hitab_bringup.swarm_files.swarm_file import read_swarm
    from hitab_client.runs.shipped import find_file

    swarm = read_swarm(find_file(name, "swarms", "swarm"))
    swarm = swarm.with_world(pace="lockstep", paused=True, seed=seed)
    with temporary_swarm(swarm, progress=lambda *_: None) as running:
        running.world.step(AT_ONCE, seconds=120.0)
        began = time.perf_counter()
        for _ in range(cycles // AT_ONCE):
            running.world.step(AT_ONCE, seconds=120.0)
        passed = time.perf_counter() - began
        missed = running.world.wait().missed_deadlines
        return cycles // AT_ONCE * AT_ONCE / passed, missed


def main(
    cycles: Annotated[int, typer.Option(help="Cycles of each measurement.")] = 300,
    turns: Annotated[int, typer.Option(help="Number of turns of each of the two.")] = 3,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Compare fifty foragers in lockstep with and without twelve commanders."""
    found: dict[str, list[float]] = {kind: [] for kind in SWARMS}
    missed = 0
    for turn in range(turns):
        for kind, name in SWARMS.items():
            cycles_per_s, late = rate(name, cycles, turn + 1)
            found[kind].append(cycles_per_s)
            missed += late
    tell(
        f"Lockstep of 50 foragers alone and under 12 commanders, medians of {turns} turns",
        {
            **{f"{kind}_cycles_per_s": round(median(rates)) for kind, rates in found.items()},
            "ratio": median(
                one / other for one, other in zip(found["commanded"], found["alone"], strict=True)
            ),
            "missed_deadlines": missed,
        },
        json,
    )


if __name__ == "__main__":
    typer.run(main)
