"""Starts a real rcssserver for keepaway, and players of UT Austin's on it.

It needs two programs that are not part of this project: rcssserver 19 and the `keepaway_player` of
UT Austin's keepaway 0.6.
"""

from __future__ import annotations

import json as js
import re
import shutil
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import typer
from report import tell

from hitab_client.measures import estimate
from hitab_rcssserver import sentences
from hitab_rcssserver.rcss_world import RcssWorld

GARBLED = re.compile(r'\tRecv \S+ \(say "[^"]*\(say "')
"""What the server logs of a player whose command was overwritten by what it says."""

END_SECONDS = 5.0
PATIENCE_SECONDS = 60.0  # for programs to start, and for an episode to begin
JOIN_SECONDS = 1.5  # between the server, the keepers and the takers, in this order


def options(
    port: int, folder: Path, fullstate: bool, side: int, others: Mapping[str, object]
) -> list[str]:
    """Return rcssserver's command line options for keepaway in a square box.

    Args:
        port: for players.
        folder: for the server's logs.
        fullstate: whether all players see everything exactly.
        side: of the box, m.
        others: more options of the server.
    """
    values: dict[str, object] = {
        "port": port,
        "coach_port": port + 1,
        "olcoach_port": port + 2,
        "keepaway": 1,
        "keepaway_length": side,
        "keepaway_width": side,
        "half_time": -1,
        "use_offside": 0,
        "forbid_kick_off_offside": 0,
        "stamina_inc_max": 3500,
        "stamina_capacity": -1,  # no limit: else players tire after some minutes of an episode
        "fullstate_l": int(fullstate),
        "fullstate_r": int(fullstate),
        "synch_mode": 1,
        "synch_offset": 80,
        "min_dash_power": -100,
        "game_logging": 0,
    }
    for log, name in (("text", "text"), ("keepaway", "keepaway")):
        values |= {
            f"{name}_logging": 1,
            f"{log}_log_dir": folder,
            f"{log}_log_fixed": 1,
            f"{log}_log_fixed_name": "game",
        }
    values["text_log_compression"] = 0
    values |= others
    return [f"server::{name}={value}" for name, value in values.items()]


def given(texts: Sequence[str] | None) -> dict[str, object]:
    """Return rcssserver's options that are given as ``server::NAME=VALUE``, by name."""
    values: dict[str, object] = {}
    for text in texts or ():
        name, equals, value = text.removeprefix("server::").partition("=")
        if not (name and equals):
            raise typer.BadParameter(f'"{text}" is not server::NAME=VALUE', param_hint="--option")
        values[name] = value
    return values


def start(stack: ExitStack, folder: Path, *command: str, count: int = 1) -> None:
    """Start a program that ends with the stack, and give it the time to join.

    Args:
        stack: ends it.
        folder: in which it runs.
        command: the program and its arguments.
        count: how often to start it.

    Raises:
        SystemExit: if there is no such program, or it has ended, with what it has printed.
    """
    found = shutil.which(command[0])
    if found is None:
        raise SystemExit(
            f"error: there is no program {command[0]}; docs/rcssserver.md and "
            "research/fidelity.md say where it comes from"
        )
    printed = folder / f"{Path(found).name}.out"
    with printed.open("a") as out:
        for _ in range(count):
            program = subprocess.Popen(
                [str(Path(found).resolve()), *command[1:]],
                cwd=folder,
                stdout=out,
                stderr=out,
            )
            stack.callback(_end, program)
    try:
        status = program.wait(JOIN_SECONDS)
    except subprocess.TimeoutExpired:
        return
    raise SystemExit(
        f"error: {found} has ended with status {status}:\n{printed.read_text(errors='replace')}"
    )


def _end(program: subprocess.Popen[bytes]) -> None:
    """End a program; UT's players do not always end when they are asked to."""
    program.send_signal(signal.SIGINT)
    try:
        program.wait(END_SECONDS)
    except subprocess.TimeoutExpired:
        program.kill()
        program.wait()


def join(world: RcssWorld) -> None:
    """Have the world's players join the server: its keepers are the first team."""
    joined = sentences.BEFORE_PLAY.format(world.server.where)
    deadline = time.monotonic() + PATIENCE_SECONDS
    while world.waiting != joined:
        if time.monotonic() > deadline:
            raise SystemExit(f"error: {world.waiting}")
        world.idle()
        time.sleep(0.001)


def start_team(
    stack: ExitStack,
    folder: Path,
    player: Path,
    port: int,
    game: tuple[int, int],
    team: str,
    policy: str = "hand",
) -> None:
    """Start UT Austin's keepers or takers, whichever ``team`` names."""
    keepers, takers = game
    arguments = f"-p {port} -k {keepers} -j {takers} -t {team} -e 0 -q {policy}"
    count = keepers if team == "keepers" else takers
    start(stack, folder, str(player.resolve()), *arguments.split(), count=count)


def lost_commands(folder: Path) -> int:
    """Return how many commands the players lost, by what the server received from them.

    A message of UT's players has ten characters, and their program reserves ten bytes for it and
    for the zero at its end. What that overwrites depends on the compiler; it may be the command of
    the same cycle. Such a message is sent when opponents are near, so that both takers and keepers
    play much worse than they should.
    """
    with (folder / "game.rcl").open(encoding="utf-8", errors="replace") as log:
        return sum(GARBLED.search(line) is not None for line in log)


def tell_lost_commands(folder: Path) -> None:
    """Warn if the players lost commands."""
    if lost := lost_commands(folder):
        print(
            f"warning: this build of keepaway_player has lost {lost} commands, and plays worse "
            "than UT Austin's players do; research/fidelity.md says how to build it"
        )


def tell_episodes(
    title: str, seconds: Sequence[float], passes: Sequence[float], out: int, json: str
) -> None:
    """Print hold time, passes and how episodes ended.

    Args:
        title: of the figures.
        seconds, passes: of each episode.
        out: how many ended because the ball left the box.
        json: file for the figures and the length of each episode; "": none.
    """
    hold, passed = estimate(seconds).rounded(), estimate(passes).rounded()
    figures: dict[str, Any] = {
        "episodes": len(seconds),
        "seconds": hold["mean"],
        "seconds_se": hold["se"],
        "passes": passed["mean"],
        "passes_se": passed["se"],
        "out_percent": round(100.0 * out / len(seconds)),
    }
    tell(title, figures)
    if json:
        figures["each_seconds"] = [round(one, 2) for one in seconds]
        Path(json).write_text(js.dumps(figures, indent=1) + "\n", encoding="utf-8")
