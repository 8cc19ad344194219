"""When an episode ends, how the next one begins, and which passes count."""

import math
from random import Random

import pytest

from keepaway_world.game.physics import Physics
from keepaway_world.game.referee import OUT, TAKEN, Referee, drop_ball, set_up
from keepaway_world.parameters import variant

PARAMETERS = variant("standard")


@pytest.fixture
def game():
    """All players far from the ball, which lies in the middle."""
    physics = Physics(PARAMETERS, Random(1))
    for number, player in enumerate(physics.players):
        physics.put(player, -9.0 + 3.0 * number, 9.0)
    return physics, Referee(PARAMETERS)


def test_the_ball_is_out_when_its_center_reaches_an_edge(game):
    physics, referee = game
    for x, y in ((10.0, 0.0), (-10.0, 0.0), (0.0, 10.0), (0.0, -10.0), (12.0, 12.0)):
        physics.put(physics.ball, x, y)
        assert referee.judge(physics) == OUT
    physics.put(physics.ball, 9.999, -9.999)
    assert referee.judge(physics) is None


def near_ball(physics, player, distance=1.0):
    physics.put(player, physics.ball.x + distance, physics.ball.y)


def far_away(physics, player):
    physics.put(player, -9.0, 9.0)


def test_the_ball_is_taken_on_the_check_after_four_cycles_of_possession(game):
    physics, referee = game
    near_ball(physics, physics.takers[0])
    assert [referee.judge(physics) for _ in range(5)] == [None] * 4 + [TAKEN]


def test_possession_holds_while_nobody_can_kick(game):
    physics, referee = game
    taker = physics.takers[1]
    for _ in range(2):
        near_ball(physics, taker)
        referee.judge(physics)
        referee.judge(physics)
        far_away(physics, taker)
        for _ in range(10):
            verdict = referee.judge(physics)
    assert verdict == TAKEN


def test_possession_is_lost_once_a_keeper_and_no_taker_can_kick(game):
    physics, referee = game
    taker, keeper = physics.takers[0], physics.keepers[2]
    near_ball(physics, taker)
    for _ in range(3):
        referee.judge(physics)
    far_away(physics, taker)
    near_ball(physics, keeper)
    referee.judge(physics)
    assert referee.possession == 0


def test_a_pass_counts_when_another_keeper_kicks_next(game):
    physics, referee = game
    (a, b, c), taker = physics.keepers, physics.takers[0]
    for player in (a, a, b, a, a, taker, b, c):
        referee.saw_kick(player)
    assert referee.passes == 3  # a to b, b to a, b to c; the taker breaks one


def in_corner(player, right, up):
    return (7.0 <= player.x * right <= 10.0) and (7.0 <= player.y * up <= 10.0)


def test_an_episode_begins_with_keepers_in_three_corners_and_takers_in_the_fourth():
    physics = Physics(PARAMETERS, Random(5))
    corners = ((-1, 1), (1, 1), (1, -1))
    seen = set()
    for _ in range(60):
        set_up(physics, Random(physics.random.random()))
        assert all(in_corner(taker, -1, -1) for taker in physics.takers)
        assert (physics.ball.x, physics.ball.y) == (-6.0, 6.0)
        where = [
            next(i for i, corner in enumerate(corners) if in_corner(keeper, *corner))
            for keeper in physics.keepers
        ]
        assert sorted(where) == [0, 1, 2]
        assert (where[1] - where[0]) % 3 == 1  # rotated, never mirrored
        seen.add(where[0])
        assert all(mover.vx == mover.vy == 0.0 for mover in physics.movers)
    assert seen == {0, 1, 2}


def test_keepers_beyond_the_third_begin_near_the_center():
    physics = Physics(variant("paper", keepers=5, takers=3), Random(2))
    set_up(physics, Random(9))
    central = [k for k in physics.keepers if math.hypot(k.x, k.y) < 1.5]
    assert len(central) == 2


def test_body_angles_can_be_kept_as_the_simulator_keeps_them():
    physics = Physics(variant("paper", reset_angles="kept"), Random(2))
    for number, player in enumerate(physics.players):
        physics.put(player, 0.0, 0.0, 0.1 * number)
    set_up(physics, Random(9))
    assert [player.heading for player in physics.players] == [0.1 * n for n in range(5)]


def test_a_ball_that_stays_about_the_same_place_for_a_hundred_cycles_is_stuck(game):
    physics, referee = game
    physics.put(physics.ball, 5.0, 5.0)
    assert not referee.finds_stuck(physics.ball)
    for cycle in range(99):
        physics.put(physics.ball, 5.0 + cycle % 3, 5.0)
        assert not referee.finds_stuck(physics.ball)
    assert referee.finds_stuck(physics.ball)
    assert not referee.finds_stuck(physics.ball)  # counted anew


def test_players_are_moved_away_from_a_dropped_ball_as_on_the_real_simulator(game):
    physics, _ = game
    keeper, taker = physics.keepers[2], physics.takers[0]
    physics.put(physics.ball, 6.814, -3.1874, 0.0, 0.3, -1.2)
    physics.put(keeper, 6.3564, -2.3684, -0.09)
    physics.put(taker, 3.4204, 0.5742, -0.71)
    far = physics.keepers[0]
    physics.put(far, -6.7101, -6.5182, 0.25)
    drop_ball(physics)
    ball = physics.ball
    assert (ball.x, ball.y, ball.vx, ball.vy) == (6.814, -3.1874, 0.0, 0.0)
    assert (keeper.x, keeper.y) == pytest.approx((2.2049, 5.0624), abs=1e-3)  # recorded
    assert (taker.x, taker.y) == pytest.approx((0.4838, 3.8291), abs=1e-3)
    assert (far.x, far.y, far.heading) == (-6.7101, -6.5182, 0.25)
