"""What rcssserver's mechanics mean beyond the recorded scenarios."""

import math
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from keepaway_world.game.angles import wrapped
from keepaway_world.game.physics import Physics
from keepaway_world.parameters import variant

QUIET = {"movement_noise": 0.0, "kick_noise": 0.0, "turn_noise": 0.0}


def make(*, seed=0, **figures):
    return Physics(variant("standard", **{"keepers": 2, "takers": 1, **figures}), Random(seed))


def far_apart(physics):
    physics.put(physics.ball, -50.0, -50.0)
    for number, player in enumerate(physics.players):
        physics.put(player, 50.0, 50.0 + 5.0 * number)


def test_powers_and_moments_beyond_their_range_are_clipped():
    beyond, at_limit = make(**QUIET), make(**QUIET)
    for physics, excess in ((beyond, 3.0), (at_limit, 1.0)):
        far_apart(physics)
        a, b, c = physics.players
        physics.put(physics.ball, c.x - 0.5, c.y)
        physics.dash(a, 100.0 * excess)
        physics.turn(b, -math.pi * excess)
        assert physics.kick(c, 100.0 * excess, math.pi)
        physics.advance()
    assert [(m.x, m.y, m.heading) for m in beyond.movers] == [
        (m.x, m.y, m.heading) for m in at_limit.movers
    ]


def test_a_ball_out_of_reach_cannot_be_kicked():
    physics = make()
    far_apart(physics)
    player = physics.keepers[0]
    physics.put(physics.ball, player.x + 1.085001, player.y)
    assert not physics.kick(player, 100.0, 0.0)
    physics.put(physics.ball, player.x + 1.084999, player.y)
    assert physics.kick(player, 100.0, 0.0)


def test_two_kicks_in_one_cycle_add_up_to_no_more_than_the_largest_acceleration():
    physics = make(**QUIET)
    far_apart(physics)
    a, b = physics.keepers
    physics.put(a, 0.0, -0.5)
    physics.put(b, 0.0, 0.5)
    physics.put(physics.ball, 0.3, 0.0)
    physics.kick(a, 100.0, 0.0)
    physics.kick(b, 100.0, 0.0)
    physics.advance()
    assert math.hypot(physics.ball.vx, physics.ball.vy) == pytest.approx(2.7 * 0.94)


@pytest.mark.parametrize("ball", [True, False])
@pytest.mark.parametrize("players", [True, False])
def test_what_overlaps_is_moved_apart_and_bounces_if_it_collides(players, ball):
    physics = make(players_collide=players, ball_collides=ball, **QUIET)
    far_apart(physics)
    a, b = physics.keepers
    physics.put(a, 0.0, 0.0, vx=0.4)
    physics.put(b, 1.0, 0.0, math.pi, vx=-0.4)
    physics.put(physics.ball, 50.0, 59.5, vy=0.4)  # before the taker
    physics.advance()
    assert (a.x, b.x) == pytest.approx((0.2, 0.8) if players else (0.4, 0.6))
    assert a.vx == pytest.approx(0.4 * 0.4 * (-0.1 if players else 1.0))
    assert (physics.ball.vy < 0.0) is ball


def test_a_crowd_on_one_spot_is_untangled():
    physics = make(keepers=4, takers=3, **QUIET)
    for player in physics.players:
        physics.put(player, 0.0, 0.0)
    for _ in range(20):
        physics.advance()
    players = physics.players
    nearest = min(
        math.hypot(a.x - b.x, a.y - b.y) for i, a in enumerate(players) for b in players[:i]
    )
    assert nearest > 0.599


angles = st.floats(-math.pi, math.pi)
powers = st.floats(-150.0, 150.0)
commands = st.tuples(st.sampled_from(["dash", "turn", "kick"]), powers, angles)


@settings(max_examples=50)
@given(st.integers(0, 2**32), st.lists(st.lists(commands, min_size=3, max_size=3), max_size=20))
def test_whatever_is_commanded_speeds_stay_in_bounds_and_nobody_overlaps(seed, plan):
    physics = make(seed=seed)
    for number, player in enumerate(physics.players):
        physics.put(player, 0.7 * number, 0.0)
    for cycle in plan:
        for player, (kind, power, angle) in zip(physics.players, cycle, strict=True):
            if kind == "dash":
                physics.dash(player, power)
            elif kind == "turn":
                physics.turn(player, angle)
            else:
                physics.kick(player, power, angle)
        physics.advance()
        for mover in physics.movers:
            speed = math.hypot(mover.vx, mover.vy)
            assert speed <= mover.speed_max * (1.0 + mover.rand) * mover.decay + 1e-9
            assert -math.pi <= mover.heading <= math.pi
            assert mover.ax == mover.ay == 0.0
        for i, a in enumerate(physics.movers):
            for b in physics.movers[:i]:
                assert math.hypot(a.x - b.x, a.y - b.y) > (a.radius + b.radius) * 0.9


@given(st.floats(-1e6, 1e6))
def test_a_wrapped_angle_points_the_same_way(angle):
    assert -math.pi <= wrapped(angle) <= math.pi
    assert math.cos(wrapped(angle)) == pytest.approx(math.cos(angle), abs=1e-6)
    assert math.sin(wrapped(angle)) == pytest.approx(math.sin(angle), abs=1e-6)
