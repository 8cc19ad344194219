"""Keepers for takers at full speed: who is where first, and whose ball it is."""

import math

import pytest

from hitab_world.inprocess import PolicyPlayer, cycle
from hitab_world.world import Placement
from keepaway_research.fullspeed import behaviors, features
from keepaway_research.fullspeed.body import FullSpeedBody
from keepaway_research.fullspeed.passing import BLOCKED, Tables
from keepaway_research.fullspeed.supporting import places
from keepaway_world.parameters import PAPER, variant
from keepaway_world.world import KeepawayWorld

QUIET = {"movement_noise": 0.0, "kick_noise": 0.0, "turn_noise": 0.0}
HALF = (8.8, 8.8)
FIELD = {
    "keeper_1": (0.0, 0.0, 0.0, 0.0, 0.0),
    "keeper_2": (7.0, 6.0, -2.4, 0.0, 0.0),
    "keeper_3": (7.0, -6.0, 2.4, 0.0, 0.0),
    "taker_1": (-8.0, 1.0, 0.0, 0.0, 0.0),
    "taker_2": (-8.0, -1.0, 0.0, 0.0, 0.0),
    "ball": (0.6, 0.0, 0.0, 0.0, 0.0),
}


@pytest.fixture
def world():
    return KeepawayWorld(variant("standard", **QUIET), seed=1)


def put(world, **places):
    world.place([Placement(name, *place) for name, place in {**FIELD, **places}.items()])


def body_of(world, name="keeper_1"):
    body = FullSpeedBody(name, world.parameters)
    body.sense(*world.percept(name))
    return body


def entity(world, name):
    return next(e for e in world.entities() if e.name == name)


def apart(world, one, other):
    a, b = entity(world, one), entity(world, other)
    return math.dist((a.x, a.y), (b.x, b.y))


def play(world, behavior, cycles, until=lambda: False):
    player = PolicyPlayer(FullSpeedBody("keeper_1", world.parameters), behavior)
    for _ in range(cycles):
        if not until():
            cycle(world, {"keeper_1": player})
    return player.body


def mate(body, number):
    return next(place for place in body.others if body.number_at(place) == number)


def slack(*takers, speed=2.2, receiver=(8.0, 0.0), half=HALF):
    return Tables(PAPER).slack((0.0, 0.0), (1.0, 0.0), speed, takers, receiver, half)


def test_time_counts_and_not_only_distance():
    """A taker as far from the lane has more time at its far end, and if it is running there."""
    at_the_start, at_the_end = (slack((x, 3.0, 0.0, 0.0)) for x in (1.0, 7.0))
    assert at_the_end < at_the_start
    assert slack((4.0, 3.0, 0.0, -0.4)) < slack((4.0, 3.0, 0.0, 0.0))
    assert slack((4.0, 3.0, 0.0, 0.0), speed=1.6) < slack((4.0, 3.0, 0.0, 0.0), speed=2.6)


@pytest.mark.parametrize(("away", "arrives"), [(-0.3, False), (-4.5, True)])
def test_the_takers_get_a_pass_without_slack_and_miss_one_with_slack(world, away, arrives):
    """The taker stands by the middle of the lane, ``away`` m from it; the mate just waits."""
    put(
        world,
        keeper_2=(8.0, 0.0, math.pi, 0.0, 0.0),
        keeper_3=(-8.0, 8.0, 0.0, 0.0, 0.0),
        taker_1=(4.0, away, math.pi / 2.0, 0.0, 0.0),
        taker_2=(-8.0, -8.0, 0.0, 0.0, 0.0),
    )
    body = body_of(world)
    assert (features.lane_slack(body, mate(body, 2)) > 0.0) == arrives
    behaviors.swift_pass_to(body, mate(body, 2))
    world.step({"keeper_1": body.act()})
    kickable = world.parameters.kickable
    while (
        apart(world, "keeper_2", "ball") > kickable and apart(world, "taker_1", "ball") > kickable
    ):
        world.step({})
    assert (apart(world, "keeper_2", "ball") <= kickable) == arrives


def test_what_was_before_a_new_episode_is_forgotten(world):
    put(world)
    body = body_of(world)
    body.await_pass(2)
    body.aim = (1.0, 1.0)
    put(world, keeper_1=(-4.0, 0.0, 0.0, 0.0, 0.0), ball=(-3.4, 0.0, 0.0, 0.0, 0.0))
    body.sense(*world.percept("keeper_1"))
    assert body.aim is None
    assert all(body.moving(place)[2:] == (0.0, 0.0) for place in (*body.others, *body.takers))
    assert features.ball_is_anothers(body) == 0.0


def test_the_ball_is_anothers_that_was_yelled_at_and_only_one_of_two_beside_it(world):
    put(world, keeper_1=(2.0, 0.0, 0.0, 0.0, 0.0), keeper_2=(8.0, 0.5, 0.0, 0.0, 0.0))
    put(world, keeper_1=(2.0, 0.0, 0.0, 0.0, 0.0), ball=(4.8, 0.0, 0.0, 0.0, 0.0))
    values, _ = world.percept("keeper_1")
    body = FullSpeedBody("keeper_1", world.parameters)
    body.sense(values, [])
    assert features.ball_is_anothers(body) == 0.0  # it is the fastest
    body.sense(values, ["pass 2"])
    assert features.ball_is_anothers(body) == 1.0
    put(world, keeper_2=(1.3, 0.2, 0.0, 0.0, 0.0))
    both = [features.ball_is_anothers(body_of(world, name)) for name in ("keeper_1", "keeper_2")]
    assert both == [0.0, 1.0]


def test_a_ball_that_rolls_past_is_met_and_stopped():
    world = KeepawayWorld(variant("standard", taker_speed=0.0, **QUIET), seed=1)
    put(
        world,
        keeper_1=(0.0, -4.0, 0.0, 0.0, 0.0),
        taker_1=(9.0, 9.0, 0.0, 0.0, 0.0),
        taker_2=(9.0, 8.0, 0.0, 0.0, 0.0),
        ball=(-7.0, 0.0, 0.0, 18.0, 0.0),
    )
    met = lambda: apart(world, "keeper_1", "ball") <= world.parameters.kickable  # noqa: E731
    play(world, behaviors.meet_ball, 30, met)
    assert met()
    play(world, behaviors.stop_ball, 3)
    ball = entity(world, "ball")
    assert met()
    assert math.hypot(ball.vx, ball.vy) < 2.0  # m/s


def test_a_supporting_keeper_stands_still_where_a_pass_can_go():
    world = KeepawayWorld(variant("standard", taker_speed=0.0, **QUIET), seed=1)
    put(
        world,
        keeper_1=(7.0, 0.0, 0.0, 0.0, 0.0),
        keeper_2=(-5.0, 0.0, 0.0, 0.0, 0.0),
        keeper_3=(-5.0, -8.0, 0.0, 0.0, 0.0),
        taker_1=(1.0, 0.0, 0.0, 0.0, 0.0),
        taker_2=(-2.0, 0.5, 0.0, 0.0, 0.0),
        ball=(-5.0, 0.5, 0.0, 0.0, 0.0),
    )
    before = features.lane_slack(body_of(world, "keeper_2"), mate(body_of(world, "keeper_2"), 1))
    body = play(world, behaviors.support, 30)
    after = features.lane_slack(body_of(world, "keeper_2"), mate(body_of(world, "keeper_2"), 1))
    assert before < 0.0 < after
    assert body.aim in places(20.0, 20.0)
    me = entity(world, "keeper_1")
    assert math.dist((me.x, me.y), body.aim) < 1.0
    assert math.hypot(me.vx, me.vy) < 0.1


def test_without_takers_or_mates_the_words_still_mean_something():
    world = KeepawayWorld(variant("standard", keepers=2, takers=0, **QUIET), seed=1)
    world.place([Placement("keeper_1", 0.0, 0.0, 0.0, 0.0, 0.0), Placement("ball", 0.5, 0.0)])
    body = body_of(world)
    diagonal = math.hypot(20.0, 20.0)
    assert features.taker_to_ball(body) == pytest.approx(diagonal)
    for nobody in (-1, 10):  # nobody, and the ball
        assert math.isnan(features.lane_slack(body, nobody))
        behaviors.swift_pass_to(body, nobody)
        assert body.act() == ([], "")
    for behavior in (behaviors.meet_ball, behaviors.stop_ball, behaviors.support):
        behavior(body)
    world.place([Placement("ball", 5.0, 0.0)])
    body.sense(*world.percept("keeper_1"))
    assert features.lane_slack(body, body.others[0]) == BLOCKED
