"""Keepers as processes of their own play on an rcssserver: on a stand-in, and on a real one."""

import importlib.util
import json
from pathlib import Path

import hitab_rcssserver

_path = Path(hitab_rcssserver.__file__).parents[1] / "test" / "rcss_stand_in.py"
_spec = importlib.util.spec_from_file_location("rcss_stand_in", _path)
stand_in = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(stand_in)

"""How docs/rcssserver.md says to start a server, and a log of its episodes."""


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
