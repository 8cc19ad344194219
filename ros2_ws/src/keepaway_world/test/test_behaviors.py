"""What the keepers' basic behaviors bring about, and what their features say."""

import math
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hitab_world.inprocess import PolicyPlayer, cycle
from hitab_world.world import Placement
from keepaway_world import behaviors, features
from keepaway_world.body import KeeperBody
from keepaway_world.domain import DOMAIN
from keepaway_world.game.kicking import pass_speed
from keepaway_world.parameters import PAPER, variant
from keepaway_world.world import KeepawayWorld


def entity(world, name):
    return next(e for e in world.entities() if e.name == name)


def body_of(world, name="keeper_1"):
    body = KeeperBody(name, world.parameters)
    body.sense(*world.percept(name))
    return body


def perform(world, behavior, name="keeper_1", cycles=1):
    player = PolicyPlayer(KeeperBody(name, world.parameters), behavior)
    for _ in range(cycles):
        cycle(world, {name: player})


def test_the_vocabulary_is_the_papers():
    going = {"GoFast", "GoMedium", "GoSlow", "Stop", "TurnTo", "TurnToBall"}
    assert set(DOMAIN.behaviors) == {*going, "Pass", "GetOpen"}
    seeing = {"DistanceTo", "DirectionTo", "BallIsKickable"}
    assert set(DOMAIN.features) == {*seeing, "IWasYelledAt", "ATeammateIsCloserToBall"}
    corners = {f"{end}_{side}_corner" for end in ("top", "bottom") for side in ("left", "right")}
    assert set(DOMAIN.targets) == {*corners, "ball", "closest_keeper", "closest_taker"}
    assert [b.name for b in DOMAIN.behaviors.values() if b.one_shot] == ["Pass"]
    assert "ServoBall" in DOMAIN.automata


@pytest.mark.parametrize("target", DOMAIN.targets)
def test_who_turns_to_something_faces_it_and_then_comes_nearer(quiet, put, target):
    world = quiet(width=24.0, taker_speed=0.0)
    put(world, keeper_1=(1.0, -2.0, 30.0), ball=(-3.0, -4.0), keeper_2=(5.0, 5.0))

    def read(feature):
        body = KeeperBody("keeper_1", world.parameters)
        body.sense(*world.percept("keeper_1"))
        return DOMAIN.features[feature].read(body, DOMAIN.targets[target].resolve(body))

    turn = DOMAIN.behaviors["TurnTo"].pulse
    perform(world, lambda body: turn(body, DOMAIN.targets[target].resolve(body)), cycles=2)
    assert read("DirectionTo") == pytest.approx(0.0, abs=1e-6)
    before = read("DistanceTo")
    perform(world, behaviors.go_fast, cycles=2)
    if target.endswith("corner"):
        right, up = (1.0 if side in target else -1.0 for side in ("right", "top"))
        me = entity(world, "keeper_1")
        assert read("DistanceTo") == math.hypot(12.0 * right - me.x, 10.0 * up - me.y)
    assert read("DistanceTo") < before - 1.0


@pytest.mark.parametrize(
    ("behavior", "speed"),
    [(behaviors.go_fast, 1.0), (behaviors.go_medium, 0.9), (behaviors.go_slow, 0.75)],
)
def test_going_moves_straight_ahead_at_the_papers_speeds(quiet, put, behavior, speed):
    world = quiet(takers=0)
    put(world, keeper_1=(-5.0, -5.0, 30.0))
    perform(world, behavior, cycles=7)
    before = entity(world, "keeper_1")
    perform(world, behavior)
    after = entity(world, "keeper_1")
    assert math.hypot(after.x - before.x, after.y - before.y) == pytest.approx(speed, abs=0.01)
    assert math.atan2(after.y + 5.0, after.x + 5.0) == pytest.approx(math.radians(30.0))


def test_a_keeper_that_stops_keeps_a_ball_that_rolls_by(quiet, put):
    world = quiet(takers=0, sight="quantised")
    put(world, keeper_1=(0.0, 0.0, 40.0), ball=(2.0, 0.3, -1.2, 0.0))
    perform(world, behaviors.stop, cycles=20)
    ball = entity(world, "ball")
    assert math.hypot(ball.vx, ball.vy) < 0.3
    assert math.hypot(ball.x, ball.y) < world.parameters.kickable


@settings(max_examples=40)
@given(st.floats(-9.0, 9.0), st.floats(-9.0, 9.0), st.floats(-3.1, 3.1), st.floats(0.0, 3.9))
def test_turning_to_the_ball_faces_it_however_fast_the_keeper_is(x, y, heading, speed):
    world = KeepawayWorld(
        variant("paper", takers=0, sight="full", turn_noise=0.0, movement_noise=0.0)
    )
    world.place(
        [
            Placement(
                "keeper_1", 0.0, 0.0, heading, speed * math.cos(heading), speed * math.sin(heading)
            ),
            Placement("keeper_2", -9.0, -9.0),
            Placement("keeper_3", -9.0, -7.0),
            Placement("ball", x, y, 0.0, 0.0, 0.0),
        ]
    )
    if math.hypot(x, y) < 1.5:
        return
    perform(world, behaviors.turn_to_ball, cycles=6)
    body = body_of(world)
    assert abs(features.direction_to(body, DOMAIN.targets["ball"].resolve(body))) < 0.01


def test_an_agent_does_without_the_simulation():
    code = "import keepaway_world.domain, sys; sys.exit('pymunk' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


@pytest.mark.parametrize("sight", ["full", "quantised"])
@pytest.mark.parametrize(
    ("receiver", "ball"),
    [
        ((6.0, 0.0), (0.5, 0.0)),  # in front
        ((-3.0, 6.0), (0.4, -0.2)),  # behind
        ((9.0, 9.0), (0.6, 0.5, -0.3, 0.1)),  # far away, rolling
        ((0.0, -5.0), (-0.3, 0.8, 0.4, -0.6)),
    ],
)
def test_a_pass_arrives_at_the_receiver_at_about_1_2_m_per_cycle(
    quiet, put, act, receiver, ball, sight
):
    world = quiet(sight=sight)
    put(
        world,
        keeper_1=(0.0, 0.0, 20.0),
        ball=ball,
        keeper_2=receiver,
        keeper_3=(-9.0, -9.0),
        taker_1=(-9.5, -9.5),
        taker_2=(-9.5, -9.0),
    )
    action = act(world, behaviors.pass_ball)
    assert action[1] == "pass 2"
    world.step({"keeper_1": action})
    nearest = (math.inf, 0.0)
    for _ in range(20):
        e = entity(world, "ball")
        away = math.hypot(e.x - receiver[0], e.y - receiver[1])
        nearest = min(nearest, (away, math.hypot(e.vx, e.vy) / 10.0))
        if world.ended:
            break
        world.step({})
    assert nearest[0] < 1.0
    assert nearest[1] == pytest.approx(1.2, abs=0.15)


def test_passes_start_at_the_speeds_of_the_ut_austin_players():
    for distance, speed in [(5, 1.54), (8, 1.74), (10, 1.85), (14, 2.09)]:
        assert pass_speed(PAPER, distance) == pytest.approx(speed, abs=0.005)


def test_a_kick_too_weak_for_the_speed_still_sends_the_ball_in_the_right_direction(
    quiet, put, act
):
    world = quiet()
    put(
        world,
        keeper_1=(0.0, 0.0, 180.0),
        ball=(0.9, 0.0, -0.5, 1.0),
        keeper_2=(9.0, 0.0),
        keeper_3=(-9.0, -9.0),
        taker_1=(-9.5, -9.5),
        taker_2=(-9.5, -9.0),
    )
    world.step({"keeper_1": act(world, behaviors.pass_ball)})
    ball = entity(world, "ball")
    assert ball.vx > 0.0
    assert math.atan2(ball.vy, ball.vx) == pytest.approx(0.0, abs=0.01)


def test_the_pass_goes_to_the_team_mate_at_the_largest_angle_from_the_closest_taker(
    quiet, put, act
):
    world = quiet()
    put(
        world,
        keeper_1=(0.0, 0.0),
        ball=(0.5, 0.0),
        keeper_2=(5.0, 1.0),
        keeper_3=(-5.0, 3.0),
        taker_1=(4.0, 0.0),
        taker_2=(-6.0, 3.6),
    )
    assert act(world, behaviors.pass_ball)[1] == "pass 3"
    put(world, taker_2=(-3.0, 2.0))  # now the closest
    assert act(world, behaviors.pass_ball)[1] == "pass 2"


def test_a_yell_is_heard_by_its_receiver_in_the_next_cycle_alone(quiet, put, act):
    world = quiet()
    put(
        world,
        keeper_1=(0.0, 0.0),
        ball=(0.5, 0.0),
        keeper_2=(6.0, 0.0),
        keeper_3=(-9.0, -9.0),
        taker_1=(-9.5, -9.5),
        taker_2=(-9.5, -9.0),
    )
    world.step({"keeper_1": act(world, behaviors.pass_ball)})
    assert entity(world, "keeper_1").say == "pass 2"
    yelled = [features.i_was_yelled_at(body_of(world, name)) for name in world.agents]
    assert yelled == [0.0, 1.0, 0.0]
    world.step({})
    assert features.i_was_yelled_at(body_of(world, "keeper_2")) == 0.0


@pytest.mark.parametrize("seed", range(6))
def test_getting_open_keeps_away_from_team_mates_and_within_10_m_of_the_center(seed):
    world = KeepawayWorld(variant("paper", takers=0), seed=seed)
    world.place([Placement("ball", 0.0, 0.0)])
    players = {name: PolicyPlayer(KeeperBody(name), behaviors.get_open) for name in world.agents}
    inside = set()
    for _ in range(150):
        cycle(world, players)
        keepers = [e for e in world.entities() if e.kind == "keeper"]
        for keeper in keepers:
            center = math.hypot(keeper.x, keeper.y)
            assert center < 10.0 or keeper.name not in inside
            if center < 9.8:
                inside.add(keeper.name)
    assert inside == set(world.agents)
    apart = [math.hypot(a.x - b.x, a.y - b.y) for a in keepers for b in keepers if a is not b]
    assert min(apart) > 12.0


def test_a_keeper_outside_the_circle_comes_back_in(quiet, put):
    world = quiet(takers=0)
    put(
        world,
        keeper_1=(11.0, 11.0, 45.0),
        keeper_2=(0.0, 0.0),
        keeper_3=(-5.0, 0.0),
        ball=(0.0, 5.0),
    )
    perform(world, behaviors.get_open, cycles=60)
    keeper = entity(world, "keeper_1")
    assert math.hypot(keeper.x, keeper.y) < 10.0


def test_features_say_what_the_keeper_sees(quiet, put):
    world = quiet()
    put(
        world,
        keeper_1=(0.0, 0.0, 90.0),
        ball=(3.0, 4.0),
        keeper_2=(3.0, 9.5),
        keeper_3=(-9.0, 0.0),
        taker_1=(0.0, -6.0),
        taker_2=(8.0, 0.0),
    )
    body = body_of(world)
    reading = {
        (name, target): DOMAIN.features[name].read(body, DOMAIN.targets[target].resolve(body))
        for name in ("DistanceTo", "DirectionTo")
        for target in ("ball", "closest_keeper", "closest_taker")
    }
    assert reading["DistanceTo", "ball"] == pytest.approx(5.0)
    assert reading["DirectionTo", "ball"] == pytest.approx(math.atan2(4.0, 3.0) - math.pi / 2.0)
    assert reading["DistanceTo", "closest_keeper"] == pytest.approx(9.0)
    assert reading["DirectionTo", "closest_keeper"] == pytest.approx(math.pi / 2.0)
    assert reading["DistanceTo", "closest_taker"] == pytest.approx(6.0)
    assert abs(reading["DirectionTo", "closest_taker"]) == pytest.approx(math.pi)
    assert features.ball_is_kickable(body) == 0.0
    assert features.a_teammate_is_closer_to_ball(body) == 0.0
    put(world, keeper_3=(3.0, 8.5))
    assert features.a_teammate_is_closer_to_ball(body_of(world)) == 1.0
    put(world, ball=(0.0, 1.0))
    assert features.ball_is_kickable(body_of(world)) == 1.0
