"""Plays UT Austin's keepaway players on a real rcssserver and reports how long they last.

The reference for the pymunk world. It needs two programs that are not part of this project:
rcssserver 19 and the `keepaway_player` of UT Austin's keepaway 0.6 (the takers may be another
build of it, with weaker dashes).

research/reference_on_rcssserver.py --player keepaway_player --seconds 60 --json real.json
research/reference_on_rcssserver.py --player keepaway_player --game 4v3 --side 25
"""

from __future__ import annotations

import re
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated

import typer
from games import size_of
from rcss_programs import (
    given,
    options,
    start,
    start_team,
    tell_episodes,
    tell_lost_commands,
)

START_SECONDS = 6  # from the server's start to the first episode
KICKED = re.compile(r"(\d+),\d+\s+Recv (keepers|takers)_(\d+): .*\(kick ")


def passes_of(folder: Path, ends: list[int]) -> list[int]:
    """Return the completed passes of each episode, by the commands that the server received."""
    passes, episode, last = [0] * len(ends), 0, ""
    for line in (folder / "game.rcl").read_text(encoding="utf-8", errors="replace").splitlines():
        found = KICKED.match(line)
        if found is None:
            continue
        while episode < len(ends) and int(found[1]) >= ends[episode]:
            episode, last = episode + 1, ""
        if episode == len(ends):
            break
        kicker = found[2] + found[3]
        if last != kicker and last.startswith("keepers") and kicker.startswith("keepers"):
            passes[episode] += 1
        last = kicker
    return passes


def main(
    player: Annotated[Path, typer.Option(help="UT Austin's program keepaway_player.")],
    taker: Annotated[Path | None, typer.Option(help="Another build, for the takers.")] = None,
    server: Annotated[str, typer.Option(help="The rcssserver program.")] = "rcssserver",
    keepers: Annotated[str, typer.Option(help="Policy: hand, rand or hold.")] = "hand",
    fullstate: Annotated[bool, typer.Option(help="All players see everything exactly.")] = False,
    game: Annotated[str, typer.Option(help="Keepers against takers, as in 4v3.")] = "3v2",
    side: Annotated[int, typer.Option(help="Of the square box, m.", min=10)] = 20,
    seconds: Annotated[float, typer.Option(help="How long to play, s.")] = 60.0,
    port: Annotated[int, typer.Option(help="Port of the server.")] = 6500,
    option: Annotated[
        list[str] | None, typer.Option(help="Another server option, as server::NAME=VALUE.")
    ] = None,
    json: Annotated[str, typer.Option(help="JSON file for the figures.")] = "",
) -> None:
    """Play episodes and print hold time, passes and how episodes ended."""
    counts = size_of(game)
    others: dict[str, object] = {"keepaway_start": START_SECONDS, "visible_angle": 360}
    others |= given(option)
    with tempfile.TemporaryDirectory() as temporary, ExitStack() as stack:
        folder = Path(temporary)
        start(stack, folder, server, *options(port, folder, fullstate, side, others))
        start_team(stack, folder, player, port, counts, "keepers", keepers)
        start_team(stack, folder, taker or player, port, counts, "takers")
        time.sleep(START_SECONDS + seconds)
        stack.close()
        lines = (folder / "game.kwy").read_text(encoding="utf-8").splitlines()
        episodes = [line.split() for line in lines if line and not line.startswith("#")]
        passes = passes_of(folder, [int(e[2]) for e in episodes])
        tell_lost_commands(folder)
    tell_episodes(
        f"UT {keepers} on rcssserver, {game} in {side} m, "
        f"{'full' if fullstate else 'quantised'} sight",
        [int(e[3]) / 10.0 for e in episodes],
        [float(p) for p in passes],
        sum(e[4] == "o" for e in episodes),
        json,
    )


if __name__ == "__main__":
    typer.run(main)
