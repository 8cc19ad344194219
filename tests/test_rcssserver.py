"""Keepers as processes of their own play on an rcssserver: on a stand-in, and on a real one."""

import contextlib
import dataclasses
import importlib.util
import json
import os
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

import keepaway_world

_path = Path(keepaway_world.__file__).parents[1] / "test" / "rcss_stand_in.py"
_spec = importlib.util.spec_from_file_location("rcss_stand_in", _path)
stand_in = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(stand_in)

RCSSSERVER = shutil.which("rcssserver")
OPTIONS = {
    "keepaway": 1,
    "keepaway_length": 20,
    "keepaway_width": 20,
    "half_time": -1,
    "use_offside": 0,
    "forbid_kick_off_offside": 0,
    "stamina_inc_max": 3500,
    "stamina_capacity": -1,
    "min_dash_power": -100,
    "visible_angle": 541,
    "fullstate_l": 1,
    "fullstate_r": 1,
    "synch_mode": 1,
    "synch_offset": 80,
    "game_logging": 0,
    "text_logging": 0,
    "keepaway_log_fixed": 1,
    "keepaway_log_fixed_name": "episodes",
}
"""How docs/rcssserver.md says to start a server, and a log of its episodes."""


@dataclasses.dataclass
class Server:
    """A server that is up, and what it knows of its own episodes."""

    port: int
    trainer_port: int
    log: Path

    def episodes(self) -> list[tuple[int, str]]:
        """Return how many cycles each of its episodes had, and why it ended."""
        lines = [line.split() for line in self.log.read_text().splitlines()]
        why = {"o": "out", "t": "taken"}
        return [(int(f[3]), why[f[4]]) for f in lines if len(f) == 5 and f[0] != "#"]


def free_ports(count: int) -> list[int]:
    with contextlib.ExitStack() as stack:
        socks = [
            stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            for _ in range(count)
        ]
        for sock in socks:
            sock.bind(("127.0.0.1", 0))
        return [sock.getsockname()[1] for sock in socks]


@pytest.fixture
def server(tmp_path):
    """A real server, on ports of its own and with a home of its own."""
    if RCSSSERVER is None:
        pytest.skip("there is no rcssserver on PATH; docs/rcssserver.md tells how to install it")
    port, trainer_port, coach_port = free_ports(3)
    options = OPTIONS | {
        "port": port,
        "coach_port": trainer_port,
        "olcoach_port": coach_port,
        "coach_w_referee": 1,
        "keepaway_log_dir": tmp_path,
    }
    with (tmp_path / "server.log").open("wb") as log:
        process = subprocess.Popen(
            [RCSSSERVER, *(f"server::{name}={value}" for name, value in options.items())],
            cwd=tmp_path,
            env=os.environ | {"HOME": str(tmp_path)},
            stdout=log,
            stderr=log,
        )
    try:
        yield Server(port, trainer_port, tmp_path / "episodes.kwy")
    finally:
        process.terminate()
        process.wait(10.0)


def evaluate(hitab, port: int, episodes: int, folder: Path, *options: str) -> dict:
    """Return the figures of `hitab keepaway evaluate` on a server."""
    path = folder / "figures.json"
    done = hitab(
        *("keepaway", "evaluate", "--world", "rcssserver", "--port", str(port)),
        *("--episodes", str(episodes), "--json", str(path), *options),
        timeout=170.0,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return json.loads(path.read_text())


def episodes_of(figures: dict) -> list[int]:
    return [round(seconds * 10) for seconds in figures["seconds_of_episodes"]]


def test_keepers_over_topics_play_what_the_stand_in_replays(hitab, tmp_path):
    with stand_in.StandIn() as server:
        figures = evaluate(hitab, server.port, 2, tmp_path)
    assert not server.errors
    # Which ones depends on whether the keepers are there before the first one is over.
    assert episodes_of(figures) in ([190, 193], [193, 246])
    assert figures["ended"] == {"out": 2, "taken": 0}
    assert figures["missed_deadlines"] == 0
    assert figures["world"] == "rcssserver"
    sorts = {text.split()[0] for number in (0, 1, 2) for text in server.commands(number)}
    assert {"(dash", "(turn"} <= sorts
    assert {text.split()[0] for text in server.commands(3)} & {"(dash", "(turn", "(kick"}


def test_keepers_over_topics_play_twenty_episodes_on_a_real_server(server, hitab, tmp_path):
    figures = evaluate(hitab, server.port, 20, tmp_path)
    told = server.episodes()[-20:]  # it may have played one before the keepers were there
    assert episodes_of(figures)[1:] == [cycles for cycles, _ in told][1:]
    assert episodes_of(figures)[0] == pytest.approx(told[0][0], abs=1)  # began to play unseen
    assert figures["ended"]["out"] == sum(why == "out" for _, why in told)
    assert figures["missed_deadlines"] == 0
    assert figures["passes"]["mean"] > 0
