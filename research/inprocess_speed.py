"""Measures how many cycles per second an in-process evaluation plays on one core.

scripts/python research/inprocess_speed.py --json speed.json
"""

from __future__ import annotations

import time
from pathlib import Path
from statistics import median
from typing import Annotated

import typer
from report import tell

from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.repertoire import Repertoire
from hitab_world.inprocess import perform, play
from keepaway_world.domain import DOMAIN
from keepaway_world.world import KeepawayWorld


def main(
    episodes: Annotated[int, typer.Option(help="Episodes in each measurement.")] = 50,
    turns: Annotated[int, typer.Option(help="How many measurements.")] = 5,
    library: Annotated[Path | None, typer.Option(help="Folder of a trained library.")] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Measure the speed of playing trained keepers in one process, on one core."""
    from hitab_client.shipped import shipped

    trained = BehaviorLibrary(library or shipped("libraries", "keepaway"), DOMAIN)
    repertoire = Repertoire(DOMAIN, trained.load())
    rates = []
    for turn in range(turns):
        world = KeepawayWorld(seed=turn)
        players = perform(world, repertoire, "Keepaway")
        began = time.process_time()
        played = play(world, players, episodes)
        rates.append(sum(p.cycles for p in played) / (time.process_time() - began))
    tell(
        f"In-process evaluation, {turns} turns of {episodes} episodes, on one core",
        {
            "cycles_per_cpu_s": round(median(rates)),
            "slowest": round(min(rates)),
            "fastest": round(max(rates)),
        },
        json,
    )


if __name__ == "__main__":
    typer.run(main)
