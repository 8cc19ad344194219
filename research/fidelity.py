"""Remakes the table of research/fidelity.md: the same keepers here and on the real simulator.

The figures of the real simulator were measured on rcssserver 19.0.0 with UT Austin's keepaway
players (`research/reference_on_rcssserver.py` remakes them) and with keepers that servo on the
ball's position.

scripts/python research/fidelity.py --episodes 200 --json fidelity.json
"""

from __future__ import annotations

import json as json_module
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any

import typer
from servo_keepers import servo_players

from hitab_client.measures import estimate
from hitab_world.inprocess import play
from keepaway_world.game.players import KEEPERS, offered
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

SLOW = {"taker_speed": 0.25}
SEEING = {"taker_policy": "reference", "sight": "quantised"}
SEEING_ALL = {"taker_policy": "reference", "sight": "full"}
POINTS = {"ball_radius": 0.001, "player_radius": 0.001, "kickable_margin": 1.083}


@dataclass(frozen=True)
class Case:
    """One row: the players, the game, and the result on the real simulator.

    Attributes:
        real: seconds, their standard error, passes, percentage that ended out; None: unknown.
    """

    title: str
    keepers: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    real: tuple[float, float, float, float] | None = None


CASES = (
    Case("UT hand, full speed", "hand", SEEING, (18.32, 0.81, 13.2, 59)),
    Case("UT hand, quarter speed", "hand", SEEING | SLOW, (53.5, 2.9, 18.9, 74)),
    Case("UT hand, collisions off", "hand", SEEING | POINTS, (22.3, 1.1, 17.4, 64)),
    Case("UT rand, full speed", "rand", SEEING, (5.11, 0.16, 5.07, 17)),
    Case("UT hold, full speed", "hold", SEEING, (3.07, 0.11, 0.11, 53)),
    Case("UT hand, full sight", "hand", SEEING_ALL, (32.9, 2.2, 9.0, 30)),
    Case("UT hand, full sight, quarter speed", "hand", SEEING_ALL | SLOW, (188.7, 23.5, 32.9, 84)),
    Case("UT rand, full sight", "rand", SEEING_ALL, (6.53, 0.11, 7.49, 3)),
    Case("servo, quarter speed", "servo", SLOW, (15.9, 0.5, 5.5, 97)),
    Case("servo, collisions off", "servo", SLOW | POINTS, (14.4, 0.4, 7.6, 95)),
)


def measure(case: Case, episodes: int, seed: int) -> dict[str, Any]:
    """Play a case and return its figures."""
    world = KeepawayWorld(variant("standard", **case.parameters), seed)
    servo = case.keepers == "servo"
    players = servo_players(world) if servo else offered(KEEPERS, case.keepers)(world)
    played = play(world, players, episodes)
    ended = Counter(result.ended for result in played)
    return {
        "case": case.title,
        "keepers": case.keepers,
        "parameters": dict(case.parameters),
        "episodes": episodes,
        "seconds": estimate([result.seconds for result in played]).rounded(),
        "passes": estimate([result.measures["passes"] for result in played]).rounded(),
        "out_percent": round(100.0 * ended["out"] / episodes),
        "real": case.real,
    }


def main(
    episodes: Annotated[int, typer.Option(help="Episodes in each case.")] = 200,
    seed: Annotated[int, typer.Option(help="Seed of the runs.")] = 1,
    only: Annotated[str, typer.Option(help="Only cases with this in their title.")] = "",
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Play all cases and print them beside the real simulator's figures."""
    print("| keepers | here: s | passes | out % | real: s | passes | out % |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    rows = []
    for case in CASES:
        if only not in case.title:
            continue
        row = measure(case, episodes, seed)
        rows.append(row)
        seconds, passes = row["seconds"], row["passes"]
        here = (
            f"{seconds['mean']:.1f} ± {seconds['se']:.1f} | "
            f"{passes['mean']:.1f} ± {passes['se']:.1f} | {row['out_percent']}"
        )
        real = "| | "
        if case.real is not None:
            real = f"{case.real[0]} ± {case.real[1]} | {case.real[2]} | {case.real[3]}"
        print(f"| {case.title} | {here} | {real} |", flush=True)
    if json:
        Path(json).write_text(json_module.dumps(rows, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    typer.run(main)
