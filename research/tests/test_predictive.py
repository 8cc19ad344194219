"""Keepers that look ahead: where the ball will be, how clear a lane is, what they do about it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_world.inprocess import PolicyPlayer, cycle
from hitab_world.world import Placement
from keepaway_research.predictive import behaviors, features
from keepaway_research.predictive.body import PredictiveBody
from keepaway_research.predictive.forecast import COMFORTABLE, HORIZON, Forecaster
from keepaway_world.parameters import PAPER, variant
from keepaway_world.percept import BALL
from keepaway_world.world import KeepawayWorld

BOX = (20.0, 20.0)
near = st.floats(-9.0, 9.0)
angle = st.floats(-math.pi, math.pi)


@pytest.fixture
def world():
    quiet = variant("paper", movement_noise=0.0, kick_noise=0.0, turn_noise=0.0, sight="full")
    return KeepawayWorld(quiet, seed=1)


def put(world, **places):
    world.place([Placement(name, *place) for name, place in places.items()])


def body_of(world, name="keeper_1"):
    body = PredictiveBody(name, world.parameters)
    body.sense(*world.percept(name))
    return body


def entity(world, name):
    return next(e for e in world.entities() if e.name == name)


def apart(world, one, other):
    a, b = entity(world, one), entity(world, other)
    return math.dist((a.x, a.y), (b.x, b.y))


def play(world, behavior, cycles, until=None):
    player = PolicyPlayer(PredictiveBody("keeper_1", world.parameters), behavior)
    for played in range(cycles):
        if until is not None and until():
            return played
        cycle(world, {"keeper_1": player})
    return cycles


@given(x=near, y=near, speed=st.floats(0.0, 3.0), bearing=angle)
def test_a_forecast_follows_the_ball_until_it_leaves_the_box(x, y, speed, bearing):
    velocity = speed * math.cos(bearing), speed * math.sin(bearing)
    track = Forecaster(PAPER).track((x, y), velocity, BOX)
    assert 1 <= len(track) <= HORIZON + 1
    rolled_x, rolled_y, vx, vy = x, y, *velocity
    for there in track:
        assert there == pytest.approx((rolled_x, rolled_y), abs=1e-9)
        assert max(abs(rolled_x), abs(rolled_y)) < 10.0 + 1e-9
        rolled_x, rolled_y = rolled_x + vx, rolled_y + vy
        vx, vy = vx * PAPER.ball_decay, vy * PAPER.ball_decay
    if len(track) <= HORIZON:
        assert max(abs(rolled_x), abs(rolled_y)) > 10.0 - 1e-9


@given(x=near, y=near, heading=angle, ball=st.tuples(near, near), velocity=st.tuples(*[near] * 2))
def test_a_meeting_is_on_the_track_and_no_sooner_than_facing_it_allows(
    x, y, heading, ball, velocity
):
    forecaster = Forecaster(PAPER)
    track = forecaster.track(ball, (velocity[0] / 5, velocity[1] / 5), BOX)
    meeting = forecaster.meet((x, y), heading, (0.0, 0.0), track)
    assert meeting.place in track
    if meeting.cycles <= HORIZON:
        assert track[meeting.cycles] == meeting.place
        assert math.dist((x, y), meeting.place) <= COMFORTABLE + 1.05 * meeting.cycles
        assert forecaster.cycles_to_meet((x, y), track) <= meeting.cycles
    # Who faces the place at which it could be first loses no time: a meeting is not put off.
    earliest = forecaster.cycles_to_meet((x, y), track)
    if 0 < earliest < len(track):
        there = track[earliest]
        facing = math.atan2(there[1] - y, there[0] - x)
        assert forecaster.meet((x, y), facing, (0.0, 0.0), track).cycles == earliest


def test_a_keeper_that_looks_ahead_meets_a_ball_that_one_who_servoes_misses(world):
    def pass_by():
        world.reset(0)
        put(
            world,
            keeper_1=(0.0, -5.0, 0.0, 0.0, 0.0),
            keeper_2=(-9.0, 9.0),
            keeper_3=(-9.0, -9.0),
            taker_1=(9.0, 9.0),
            taker_2=(9.0, 8.0),
            ball=(-6.0, 0.0, 0.0, 18.0, 0.0),
        )

    def met():
        return apart(world, "keeper_1", "ball") <= PAPER.kickable

    pass_by()
    looks_ahead = play(world, behaviors.intercept_ball, 60, met)
    assert met()
    assert not world.ended

    def servo(body):
        off = body.values[BALL + 1]
        body.turn_by(off) if abs(off) > 0.15 else body.dash(100.0)

    pass_by()
    servoes = play(world, servo, looks_ahead, met)
    assert not met()
    assert servoes == looks_ahead


def test_a_keeper_offers_itself_where_no_taker_is_in_the_lane():
    world = KeepawayWorld(variant("paper", taker_speed=0.0), seed=1)
    put(
        world,
        keeper_1=(7.0, 0.0, 0.0, 0.0, 0.0),
        keeper_2=(-5.0, 0.0, 0.0, 0.0, 0.0),
        keeper_3=(-5.0, -8.0),
        taker_1=(1.0, 0.0, 0.0, 0.0, 0.0),
        taker_2=(-2.0, 0.5, 0.0, 0.0, 0.0),
        ball=(-5.0, 0.5, 0.0, 0.0, 0.0),
    )
    mate = body_of(world, "keeper_2")
    place = next(p for p in mate.others if mate.number_at(p) == 1)
    before = features.lane_clearance(mate, place)
    play(world, behaviors.offer_pass, 20)
    after = features.lane_clearance(body_of(world, "keeper_2"), place)
    assert before < 0.5
    assert after > 1.5  # m: what the lessons call clear
    assert math.hypot(entity(world, "keeper_1").x, entity(world, "keeper_1").y) < 9.0


def test_who_is_faster_to_the_ball_depends_on_where_it_rolls(world):
    places = {
        "keeper_1": (0.0, 0.0, 0.0, 0.0, 0.0),
        "keeper_2": (8.0, 0.0, 0.0, 0.0, 0.0),
        "keeper_3": (-9.0, 9.0),
        "taker_1": (-9.0, -9.0),
        "taker_2": (-8.0, -9.0),
    }
    put(world, **places, ball=(3.0, 0.0, 0.0, 0.0, 0.0))
    assert features.a_teammate_is_faster_to_ball(body_of(world)) == 0.0
    assert features.a_teammate_is_faster_to_ball(body_of(world, "keeper_2")) == 1.0
    put(world, **places, ball=(3.0, 0.0, 0.0, 20.0, 0.0))
    assert features.a_teammate_is_faster_to_ball(body_of(world)) == 1.0
    assert features.a_teammate_is_faster_to_ball(body_of(world, "keeper_2")) == 0.0
