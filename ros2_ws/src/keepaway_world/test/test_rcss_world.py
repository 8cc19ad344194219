"""Keepaway on an rcssserver, as a stand-in replays it from a recorded transcript."""

import contextlib
import importlib.util
import math
import random
import socket
import statistics
import time
from pathlib import Path

import pytest

from hitab_world.world import LOOK, RESTART, LiveWorld, Placement, WorldError
from keepaway_world import percept
from keepaway_world.parameters import PAPER, variant
from keepaway_world.rcss.episode_watch import EpisodeWatch
from keepaway_world.rcss.field import Field
from keepaway_world.rcss.rcss_world import RcssWorld
from keepaway_world.rcss.server_settings import ServerSettings
from keepaway_world.referee import Referee

_spec = importlib.util.spec_from_file_location(
    "rcss_stand_in", Path(__file__).parent / "rcss_stand_in.py"
)
stand_in = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(stand_in)
StandIn = stand_in.StandIn

EPISODES = [(190, "out"), (193, "out"), (246, "out")]
"""How the three episodes of the transcript went."""


@contextlib.contextmanager
def world_on(server, patience=20.0, **settings):
    """Make a world on a server that is there already, and leave it at the end."""
    world = RcssWorld(
        ServerSettings(port=server.port, **settings), variant("standard"), patience=patience
    )
    try:
        yield world
    finally:
        world.close()
    assert not server.errors


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def idle_until(world, condition, seconds=15.0):
    """Keep a world company as a node does; return all that has happened."""
    happened = []
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, world.waiting
        happened.append(world.idle())
        time.sleep(0.005)
    return [what for what in happened if what]


def play(world, episodes=3):
    """Play episodes with keepers that do nothing; return their results."""
    results = []
    for episode in range(episodes):
        world.reset(episode)
        while not world.ended and not world.waiting:
            world.step({})
        if world.waiting:
            break
        results.append(world.result())
    return results


def test_it_is_a_world_that_goes_on_by_itself():
    world = RcssWorld()
    assert isinstance(world, LiveWorld)
    assert world.agents == ("keeper_1", "keeper_2", "keeper_3")
    assert "127.0.0.1:6000" in world.waiting


def test_episodes_end_when_and_why_the_servers_did():
    with StandIn() as server, world_on(server) as world:
        results = play(world)
    assert [(r.cycles, r.ended) for r in results] == EPISODES
    assert [r.number for r in results] == [0, 1, 2]
    assert [r.seconds for r in results] == pytest.approx([19.0, 19.3, 24.6])
    assert all(r.measures["passes"] >= 3 for r in results)


def test_a_ball_that_a_taker_has_had_long_enough_was_taken():
    field = Field(PAPER)
    watch = EpisodeWatch(Referee(PAPER), field.physics)
    watch.begin(7)
    field.put(dict.fromkeys(field.movers, (9.0, 9.0, 0.0, 0.0, 0.0)))
    field.put({"taker_1": (0.0, 0.0, 0.0, 0.0, 0.0), "ball": (1.0, 0.0, 0.0, 0.1, 0.0)})
    for _ in range(PAPER.turnover_cycles):
        assert watch.why_over() == "out"
        watch.saw(())
    assert watch.why_over() == "taken"
    field.put({"ball": (9.5, 0.0, 0.0, 1.0, 0.0)})
    assert watch.why_over() == "out"


def test_a_pass_is_a_kick_and_another_keepers_kick_after_it():
    field = Field(PAPER)
    watch = EpisodeWatch(Referee(PAPER), field.physics)
    watch.begin(0)
    kicks = ["keeper_1"], ["keeper_1"], ["keeper_2"], [], ["taker_1"], ["keeper_1"], ["keeper_3"]
    for kickers in kicks:
        watch.saw(kickers)
    assert watch.passes == 2
    watch.begin(7)
    assert (watch.passes, watch.began) == (0, 7)


def test_a_percept_is_the_full_state_in_the_keepers_own_layout():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        values, heard = world.percept("keeper_2")
    # ((b) -6 -6 0 0) ((p l 2 0) 8.3179 7.1932 0 0 0 0): y points down there, up here
    assert values[percept.NUMBER] == 2
    assert values[percept.KEEPERS], values[percept.TAKERS] == (3, 2)
    assert values[percept.X] == 8.3179
    assert values[percept.Y] == -7.1932
    dx, dy = -6 - 8.3179, 6 + 7.1932
    assert values[percept.BALL] == pytest.approx(math.hypot(dx, dy))
    assert values[percept.BALL + 1] == pytest.approx(math.atan2(dy, dx))
    assert len(values) == percept.percept_length(3, 2)
    assert heard == []


def test_headings_and_velocities_are_turned_round():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        world.step({})  # (p l 1 0) 8.93974 -7.95192 0 0 140.682
        assert world.percept("keeper_1")[0][percept.HEADING] == pytest.approx(
            math.radians(-140.682)
        )
        while world.episode_cycle < 100:
            world.step({})
        truth = {entity.name: entity for entity in world.entities()}
        values = world.percept("keeper_1")[0]
    assert values[percept.VX] == pytest.approx(truth["keeper_1"].vx)
    assert values[percept.BALL_VY] == pytest.approx(truth["ball"].vy)
    assert {entity.kind for entity in truth.values()} == {"ball", "keeper", "taker"}


def test_a_keeper_hears_its_team_mates_but_neither_itself_nor_takers():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        heard = {}
        while not world.ended:
            world.step({})
            heard[world.episode_cycle] = world.percept("keeper_1")[1]
    assert heard[41] == ["p1"]
    assert heard[77] == []  # its own words
    assert heard[106] == ["p3"]


def test_actions_become_commands_with_y_down_and_degrees():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        world.step(
            {
                "keeper_1": ([1.0, 250.0], "pass 2"),
                "keeper_2": ([2.0, math.pi / 2], ""),
                "keeper_3": ([3.0, 50.0, -math.pi / 4], ""),
            }
        )
        world.step({"keeper_1": ([], "a & b"), "keeper_2": ([9.0], ""), "nobody": ([], "")})
        assert set(world.refused) == {"keeper_1", "keeper_2", "nobody"}
        assert "letters" in world.refused["keeper_1"]
    assert server.commands(0)[:2] == ["(dash 100.0000)", '(say "pass 2")']
    assert server.commands(1)[:1] == ["(turn -90.0000)"]
    assert server.commands(2)[:1] == ["(kick 50.0000 45.0000)"]
    assert server.commands(3)  # a taker, which the world plays
    assert "(bye)" in server.commands(4) or server.commands(4)


def test_takers_may_be_someone_elses():
    with StandIn(players=3) as server, world_on(server, our_takers=False) as world:
        assert [(r.cycles, r.ended) for r in play(world)] == EPISODES
    assert {number for number, _ in server.received} == {0, 1, 2}


def test_the_server_is_told_to_begin_once_all_players_are_there():
    with StandIn(begun=False) as server, world_on(server) as world:
        assert [(r.cycles, r.ended) for r in play(world, 1)] == EPISODES[:1]
        assert server.begun


def test_a_server_that_somebody_else_is_to_begin_is_left_alone():
    with StandIn(begun=False) as server, world_on(server, kick_off=False, patience=1.0) as world:
        with pytest.raises(WorldError, match="has not begun to play"):
            world.reset(0)
        assert not server.begun


def test_keepers_may_perceive_what_they_see_while_viewers_see_the_truth():
    with StandIn() as server, world_on(server, percepts="see") as world:
        world.reset(0)
        off, ball = [], []
        while not world.ended:
            world.step({})
            truth = {entity.name: entity for entity in world.entities()}
            me, values = truth["keeper_1"], world.percept("keeper_1")[0]
            off.append(math.hypot(values[percept.X] - me.x, values[percept.Y] - me.y))
            distance = math.hypot(truth["ball"].x - me.x, truth["ball"].y - me.y)
            ball.append(abs(values[percept.BALL] - distance))
        assert (world.result().cycles, world.ended) == EPISODES[0]
    # This server lets its players see a quarter of what is around them, in two cycles of three.
    assert 0.0 < statistics.median(off) < 0.3
    assert 0.0 < statistics.median(ball) < 1.0
    assert "(synch_see)" in server.commands(0)
    assert "(synch_see)" not in server.commands(3)


def test_a_server_that_tells_no_full_state_is_played_on_by_what_the_players_see():
    def blind(text):
        return text.replace("(fullstate_l 1)", "(fullstate_l 0)")

    with (
        StandIn(edit=blind, lose=lambda text, _: text.startswith("(fullstate")) as server,
        world_on(server, percepts="see") as world,
    ):
        results = play(world)
        assert {entity.kind for entity in world.entities()} == {"ball", "keeper", "taker"}
    assert [r.cycles for r in results] == [cycles for cycles, _ in EPISODES]


def test_without_synch_mode_the_server_goes_on_by_itself():
    def realtime(text):
        return text.replace("(synch_mode 1)", "(synch_mode 0)")

    with StandIn(synch=False, edit=realtime) as server, world_on(server) as world:
        results = play(world)
    assert [(r.cycles, r.ended) for r in results] == EPISODES
    assert not any(text == "(done)" for _, text in server.received)


@pytest.mark.parametrize("seed", [1, 2])
def test_lost_datagrams_change_no_result(seed):
    draw = random.Random(seed).random
    sorts = ("(sense", "(full", "(hear", "(think", "(done", "(turn", "(dash")

    def lose(text, number):
        return text.startswith(sorts) and draw() < 0.001

    with StandIn(lose=lose) as server, world_on(server) as world:
        results = play(world)
    assert [(r.cycles, r.ended) for r in results] == EPISODES


def test_an_episode_whose_end_nobody_hears_ends_all_the_same():
    with (
        StandIn(lose=lambda text, number: "training" in text) as server,
        world_on(server) as world,
    ):
        results = play(world, 2)
    assert [(r.cycles, r.ended) for r in results] == EPISODES[:2]


def test_garbled_datagrams_are_dropped():
    draw = random.Random(1).random

    def garble(text):
        return text[: len(text) // 2] if text.startswith("(see") or draw() < 0.001 else text

    with StandIn(edit=garble) as server, world_on(server) as world:
        assert [(r.cycles, r.ended) for r in play(world)] == EPISODES


def test_a_server_that_starts_late_is_waited_for():
    port = free_port()
    world = RcssWorld(ServerSettings(port=port), variant("standard"))
    world.idle()
    assert world.waiting == (
        f"no rcssserver answers at 127.0.0.1:{port}; start it, or correct the address "
        "(host and port)"
    )
    with pytest.raises(WorldError, match="no rcssserver answers"):
        world.step({})
    with StandIn(port=port):
        assert idle_until(world, lambda: not world.waiting) == [RESTART]
        assert world.step({}) is None
        assert world.episode_cycle == 1
        world.close()


def test_a_server_that_stops_is_reported_and_one_that_restarts_is_played_on():
    port = free_port()
    with StandIn(port=port) as server:
        world = RcssWorld(ServerSettings(port=port), variant("standard"))
        idle_until(world, lambda: not world.waiting)
        for _ in range(50):
            world.step({})
    began = time.monotonic()
    assert world.step({}) is None
    assert time.monotonic() - began < 5.0
    assert world.waiting == f"the rcssserver at 127.0.0.1:{port} has gone; start it again"
    assert not server.errors
    with StandIn(port=port):
        assert idle_until(world, lambda: not world.waiting) == [RESTART]
        assert world.episode_cycle == 0
        while not world.ended:
            world.step({})
        assert (world.result().cycles, world.ended) == EPISODES[0]
        world.close()


def test_a_server_that_hangs_is_reported():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        server.silent = True
        began = time.monotonic()
        world.step({})
        assert 3.0 < time.monotonic() - began < 6.0
        assert "has been silent for 4 s" in world.waiting


def test_what_cannot_be_played_on_is_told_in_a_sentence():
    for options, settings, told in [
        ({"version": 9}, {}, "does not speak protocol version 15"),
        ({"edit": lambda text: "hello"}, {}, "is not an rcssserver"),
        ({"edit": lambda t: t.replace("(init r", "(init l")}, {}, "are the wrong team"),
        (
            {"edit": lambda t: t.replace("(init l 1", "(init l 4")},
            {},
            "other clients are, or were, the keepers",
        ),
        (
            {"edit": lambda t: t.replace("(keepaway 1)", "(keepaway 0)")},
            {},
            "start it with server::keepaway=1",
        ),
        (
            {"edit": lambda t: t.replace("(fullstate_l 1)", "(fullstate_l 0)")},
            {},
            "start it with server::fullstate_l=1",
        ),
        ({"edit": lambda t: t.replace("(keepaway_width 20)", "(keepaway_width 2)")}, {}, "12 m"),
        ({"lose": lambda t, n: t.startswith("(server_param")}, {}, "sends no settings"),
        (
            {"edit": lambda t: t.replace("(fullstate_l 1)", "(fullstate_l 0)")},
            {},
            "set the parameter percepts to see",
        ),
        ({"lose": lambda t, n: t.startswith("(init")}, {}, "was lost"),
        ({"players": 3}, {"our_takers": False}, ""),
    ]:
        with StandIn(**options) as server:
            world = RcssWorld(ServerSettings(port=server.port, **settings), variant("standard"))
            world.idle()
            assert told in world.waiting
            assert "\n" not in world.waiting
            world.close()


def test_other_counts_of_players_than_the_worlds_are_told():
    with StandIn(players=4) as server:
        world = RcssWorld(
            ServerSettings(port=server.port, our_takers=True), variant("standard", takers=1)
        )
        idle_until(world, lambda: "the server has 2 takers but this world 1" in world.waiting)
        world.close()


def test_a_host_that_does_not_exist_is_told():
    world = RcssWorld(ServerSettings(host="no.such.host.invalid"))
    world.idle()
    assert "is not the address of a server" in world.waiting


def test_settings_that_cannot_be_are_refused():
    for settings, told in [
        ({"port": 0}, "port is 0"),
        ({"trainer_port": 70000}, "trainer_port is 70000"),
        ({"port": "six thousand"}, "port is 'six thousand'; it must be a whole number"),
        ({"team": "too long a team's name"}, "a team has a name of"),
        ({"taker_team": "keepers"}, "both teams"),
        ({"percepts": "heard"}, "must be one of: fullstate, see"),
    ]:
        with pytest.raises(ValueError, match=told):
            ServerSettings(**settings)


def test_what_a_server_cannot_do_is_refused_with_the_way_out():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        with pytest.raises(WorldError, match="coach_w_referee=1"):
            world.place([Placement("ball", 0.0, 0.0)])
        with pytest.raises(WorldError, match="cannot be saved"):
            world.snapshot()
        with pytest.raises(WorldError, match="cannot be saved or restored"):
            world.restore({})
        with pytest.raises(WorldError, match="start it with seed 7"):
            world.reset(0, 7)
        with pytest.raises(WorldError, match="cannot repeat or skip to episode 5"):
            world.reset(5)


def test_a_trainer_puts_things_somewhere_and_begins_episodes():
    with StandIn() as server, world_on(server, trainer_port=server.trainer_port) as world:
        world.reset(0)
        world.step({})
        world.place([Placement("ball", 1.0, 2.0, vx=3.0), Placement("keeper_2", heading=0.5)])
        places = {entity.name: entity for entity in world.entities()}
        assert (places["ball"].x, places["ball"].y, places["ball"].vx) == (1.0, 2.0, 3.0)
        x, y = (float(word) for word in server.moves[1].split()[4:6])
        assert server.moves[0].startswith("(move (ball) 1.000000 -2.000000 0.000000 0.300000 ")
        assert server.moves[1].startswith("(move (player keepers 2) ")
        assert (x, y) == pytest.approx((places["keeper_2"].x, -places["keeper_2"].y), abs=1e-5)
        assert "-28.647890" in server.moves[1]
        world.reset()
        assert (world.waiting, world.episode, world.episode_cycle) == ("", 1, 0)
        assert len(server.moves) == 2 + 6  # all that there is
        assert world.entities()[0].x == pytest.approx(-6.0)


def test_a_pause_puts_everything_back_where_a_trainer_can():
    with StandIn() as server, world_on(server, trainer_port=server.trainer_port) as world:
        world.reset(0)
        for _ in range(20):
            world.step({})
        before = world.entities()
        idle_until(world, lambda: len(server.moves) >= 6)
        assert world.entities() == before


def test_a_server_that_goes_while_it_is_paused_is_reported():
    port = free_port()
    with StandIn(port=port) as server:
        world = RcssWorld(
            ServerSettings(port=port, trainer_port=server.trainer_port), variant("standard")
        )
        idle_until(world, lambda: not world.waiting)
    idle_until(world, lambda: world.waiting)
    assert f"127.0.0.1:{port}" in world.waiting
    world.close()


def test_an_episode_that_has_begun_must_end_before_the_next_is_counted():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        for _ in range(10):
            world.step({})
        world.reset(0)  # waits for the rest of the transcript's first episode
        assert world.episode == 0
        assert world.episode_cycle == 0
        while not world.ended:
            world.step({})
        assert (world.result().cycles, world.ended) == EPISODES[1]


def test_a_pause_holds_the_server_to_about_a_cycle_a_second():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        world.step({})
        before = world.cycle
        began = time.monotonic()
        happened = idle_until(world, lambda: time.monotonic() - began > 2.5)
        # Without it, the server would go on as fast as this machine lets it: hundreds of cycles.
        assert 1 <= world.cycle - before <= time.monotonic() - began + 1
        assert set(happened) == {LOOK}


def test_the_figures_of_the_game_are_the_servers():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        assert world.size == (20.0, 20.0)
        assert world.parameters.kickable == pytest.approx(1.085)
        assert world.parameters.taker_speed == 1.0  # ours to decide
    assert PAPER.say_length == world.parameters.say_length == 10
