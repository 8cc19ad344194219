"""Half-field attack on an rcssserver: on a stand-in that replays one, and on a real one."""

import contextlib
import importlib.util
import shutil
import socket
import subprocess
from pathlib import Path

import pytest

from half_field_world.game import half_field, rules_of
from half_field_world.parameters import HalfFieldParameters
from hitab_rcssserver.rcss_world import RcssWorld
from hitab_rcssserver.server_settings import ServerSettings
from hitab_world.world import Placement

_spec = importlib.util.spec_from_file_location(
    "rcss_stand_in", Path(__file__).parent / "rcss_stand_in.py"
)
stand_in = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(stand_in)

EPISODES = [("caught", 73), ("goal", 62), ("offside", 50)]
"""How the three episodes of the transcript ended, with the server's referee."""


@contextlib.contextmanager
def world_at(port, trainer_port, seed=7, **settings):
    """Make a world on a server that is there already, and leave it at the end."""
    parameters = HalfFieldParameters()
    server = ServerSettings(
        port=port, trainer_port=trainer_port, team="attackers", taker_team="defenders", **settings
    )
    world = RcssWorld(server, parameters, seed, rules_of(parameters), patience=20.0)
    try:
        yield world
    finally:
        world.close()


@contextlib.contextmanager
def replayed(**options):
    """Yield a stand-in that replays half-field attack, and a world on it."""
    with stand_in.StandIn(path=stand_in.HALF_FIELD, players=6, begun=False, **options) as server:
        with world_at(server.port, server.trainer_port) as world:
            yield server, world
        assert not server.errors


def finished(world, episode):
    world.reset(episode)
    while not world.ended:
        world.step({})
    return world.result()


def test_episodes_end_when_and_why_the_servers_referee_said():
    with replayed() as (server, world):
        results = [finished(world, episode) for episode in range(3)]
        kinds = {entity.kind for entity in world.entities()}
    assert [(r.ended, r.cycles) for r in results] == EPISODES
    assert [r.measures["goals"] for r in results] == [0.0, 1.0, 0.0]
    assert [r.measures["passes"] for r in results] == [8.0, 0.0, 4.0]
    assert kinds == {"attacker", "defender", "goalie", "ball", "post"}
    assert server.goalies == [False] * 5 + [True]
    assert any(text.startswith("(catch ") for text in server.commands(5))
    assert not any(text.startswith("(catch ") for text in server.commands(4))


def test_each_episode_begins_as_in_the_simulated_game_on_the_servers_right_half():
    with replayed() as (server, world):
        world.reset(0)
        finished(world, 4)
        there = {entity.name: entity for entity in half_field(seed=7).entities()}
    assert len(server.moves) == 2 * 7
    x, y = (float(word) for word in server.moves[0].split()[2:4])
    assert (x, y) == pytest.approx((there["ball"].x + 26.25, -there["ball"].y), abs=1e-5)


def test_what_is_placed_stands_there_on_the_server_with_its_number():
    with replayed() as (server, world):
        world.reset(0)
        world.place([Placement("goalie", 20.0, 1.0, 0.0, 0.0, 0.0)])
    assert server.moves[-1].startswith("(move (player defenders 3) 46.250000 -1.000000 ")


def test_half_field_attack_needs_a_trainer_and_a_server_that_plays_a_match():
    def keepaway(text):
        return text.replace("(keepaway 0)", "(keepaway 1)")

    with world_at(6000, 0) as world:
        world.idle()
        assert "lets only a trainer move things" in world.waiting
    with replayed(edit=keepaway) as (_, world):
        world.idle()
        assert "start it with server::keepaway=0" in world.waiting


def free_ports():
    """Return the first of three free ports in a row."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        return min(sock.getsockname()[1], 65000)


@pytest.mark.skipif(shutil.which("rcssserver") is None, reason="rcssserver is not installed")
def test_on_a_real_server_attackers_that_do_nothing_lose_the_ball(tmp_path):
    port = free_ports()
    options = {
        "port": port,
        "coach_port": port + 1,
        "olcoach_port": port + 2,
        "half_time": -1,
        "fullstate_l": 1,
        "synch_mode": 1,
        "synch_offset": 80,
        "coach_w_referee": 1,
        "game_logging": 0,
        "text_logging": 0,
    }
    server = subprocess.Popen(
        ["rcssserver", *(f"server::{name}={value}" for name, value in options.items())],
        cwd=tmp_path,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        with world_at(port, port + 1) as world:
            results = [finished(world, episode) for episode in range(4)]
    finally:
        server.terminate()
        server.wait(5.0)
    assert {r.ended for r in results} <= {"taken", "caught"}
    assert [r.number for r in results] == [0, 1, 2, 3]
