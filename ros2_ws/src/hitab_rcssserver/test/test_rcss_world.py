"""Keepaway on an rcssserver, as a stand-in replays it from a recorded transcript."""

import contextlib
import importlib.util
import math
import random
import socket
import statistics
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

from hitab_rcssserver.game import ReportedGame
from hitab_rcssserver.messages import EPISODE_OVER, FullState, PlayerState
from hitab_rcssserver.rcss_world import RcssWorld
from hitab_rcssserver.server_settings import ServerSettings
from hitab_world.world import LOOK, RESTART, LiveWorld, Placement, WorldError
from keepaway_world import percept
from keepaway_world.game.rules import KEEPAWAY_RULES
from keepaway_world.parameters import PAPER, variant

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


draw = random.Random(1).random
SORTS = ("(sense", "(full", "(hear", "(think", "(done", "(turn", "(dash")


def realtime(text):
    return text.replace("(synch_mode 1)", "(synch_mode 0)")


def garbled(text):
    return text[: len(text) // 2] if text.startswith("(see") or draw() < 0.001 else text


@pytest.mark.parametrize(
    ("server", "settings"),
    [
        pytest.param({}, {}, id="a server that waits for its players"),
        pytest.param({"begun": False}, {}, id="one that waits for a command to begin"),
        pytest.param({"players": 3}, {"our_takers": False}, id="somebody else's takers"),
        pytest.param({"synch": False, "edit": realtime}, {}, id="real time"),
        pytest.param({"edit": garbled}, {}, id="garbled datagrams"),
        pytest.param(
            {"lose": lambda text, _: text.startswith(SORTS) and draw() < 0.001}, {}, id="lost ones"
        ),
        pytest.param({"lose": lambda text, _: "training" in text}, {}, id="ends nobody hears of"),
    ],
)
def test_episodes_end_when_and_why_the_servers_did(server, settings):
    with StandIn(**server) as there, world_on(there, **settings) as world:
        results = play(world, 2)
        assert world.size == (20.0, 20.0)
        assert world.parameters.kickable == pytest.approx(1.085)
        assert world.parameters.taker_speed == 1.0  # ours to decide
    assert [(r.number, r.cycles, r.ended) for r in results] == [(0, 190, "out"), (1, 193, "out")]
    assert [r.seconds for r in results] == pytest.approx([19.0, 19.3])
    assert all(r.measures["passes"] >= 3 for r in results)
    assert there.begun
    assert any(text == "(done)" for _, text in there.received) == there.synch


class Reports(SimpleNamespace):
    """What a server reports of a game in a cycle: a link to it."""

    def states(self):
        return self.now


def state(time, ball, kicker=0):
    """Return a cycle in which all stand still: keeper n at (0, 4n), a taker at (0, 0)."""
    keepers = [PlayerState("l", n, 0, 4 * n, 0, 0, 0, n == kicker) for n in (1, 2, 3)]
    players = (*keepers, PlayerState("r", 1, 0, 0, 0, 0, 0), PlayerState("r", 2, 9, 9, 0, 0, 0))
    return FullState(time, "play_on", ball, players)


def reported(game, time, ball, kicker=0, over=False):
    """Report a cycle."""
    said = {(time, EPISODE_OVER)} if over else set()
    now = [state(time, ball, kicker)]
    return game.take(Reports(time=time, now=now, referee=said, clients={}))


@pytest.mark.parametrize(
    ("cycles", "ball", "why"),
    [(3, (0.5, 0, 0, 0), "out"), (4, (0.5, 0, 0, 0), "taken"), (5, (9.5, 0, 1, 0), "out")],
)
def test_why_an_episode_is_over_follows_from_what_was_seen(cycles, ball, why):
    game = ReportedGame(PAPER, KEEPAWAY_RULES, by_sight=False)
    game.mode = "play_on"
    for cycle in range(cycles - 1):
        assert reported(game, cycle, (0.5, 0, 0, 0)).ended == ""
    reported(game, cycles - 1, ball)
    turn = reported(game, cycles, (6, -6, 0, 0), over=True)
    assert (turn.ended, turn.began) == (why, True)


def test_a_pass_is_a_kick_and_another_keepers_kick_after_it():
    game = ReportedGame(PAPER, KEEPAWAY_RULES, by_sight=False)
    game.mode = "play_on"
    for cycle, kicker in enumerate((1, 1, 2, 3, 3)):
        reported(game, cycle, (0, 4 * kicker, 0, 0))
        turn = reported(game, cycle, (0, 4 * kicker, 0, 0), kicker)
    assert turn.measures == {"passes": 2.0}


@pytest.mark.parametrize("over", [False, True])
def test_who_stood_still_for_some_cycles_counts_the_passes_in_all_of_them(over):
    game = ReportedGame(PAPER, KEEPAWAY_RULES, by_sight=False)
    reported(game, 0, (0, 4, 0, 0), over=True)
    cycles = [state(n, (0, 4 * k, 0, 0), k) for n in range(1, 7) for k in [(n + 1) // 2]]
    said = {(7, EPISODE_OVER)} if over else set()
    cycles.append(state(7, (6, -6, 0, 0)))
    turn = game.take(Reports(time=7, now=cycles, referee=said, clients={}))
    assert (turn.measures["passes"], turn.passed, turn.began) == (2.0, 7, over)


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


def test_in_play_headings_and_velocities_are_turned_round_and_team_mates_heard():
    with StandIn() as server, world_on(server) as world:
        world.reset(0)
        heard = {}
        while world.episode_cycle < 110:
            world.step({})
            values, heard[world.episode_cycle] = world.percept("keeper_1")
            if world.episode_cycle == 1:  # (p l 1 0) 8.93974 -7.95192 0 0 140.682
                assert values[percept.HEADING] == pytest.approx(math.radians(-140.682))
        truth = {entity.name: entity for entity in world.entities()}
    assert values[percept.VX] == pytest.approx(truth["keeper_1"].vx)
    assert values[percept.BALL_VY] == pytest.approx(truth["ball"].vy)
    assert {entity.kind for entity in truth.values()} == {"ball", "keeper", "taker"}
    assert (heard[41], heard[77], heard[106]) == (["p1"], [], ["p3"])  # at 77, its own words


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


def instead(old, new):
    return {"edit": lambda text: text.replace(old, new)}


def test_what_cannot_be_played_on_is_told_in_a_sentence():
    for options, told in [
        ({"version": 9}, "restart it: it must speak protocol version 15"),
        ({"edit": lambda text: "hello"}, "is not an rcssserver"),
        (instead("(init r", "(init l"), "other clients are, or were, the takers"),
        (instead("(init l 1", "(init l 4"), "other clients are, or were, the keepers"),
        (instead("(keepaway 1)", "(keepaway 0)"), "start it with server::keepaway=1"),
        (instead("(fullstate_l 1)", "(fullstate_l 0)"), "set the parameter percepts to see"),
        (instead("(keepaway_width 20)", "(keepaway_width 2)"), "12 m"),
        ({"lose": lambda t, n: t.startswith("(server_param")}, "sends no settings"),
        ({"lose": lambda t, n: t.startswith("(init")}, "was lost"),
    ]:
        with StandIn(**options) as server:
            world = RcssWorld(ServerSettings(port=server.port), variant("standard"))
            world.idle()
            assert told in world.waiting
            assert "\n" not in world.waiting
            world.close()
    world = RcssWorld(ServerSettings(host="no.such.host.invalid"))
    world.idle()
    assert isinstance(world, LiveWorld)
    assert "is not the address of a server" in world.waiting
    with StandIn(players=4) as server:
        world = RcssWorld(ServerSettings(port=server.port), variant("standard", takers=1))
        idle_until(world, lambda: "the server has 2 takers but this world 1" in world.waiting)
        world.close()


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
