"""Half-field attack: how an episode begins and ends, and what the opponents do."""

import math
from random import Random

import pytest

from half_field_world import field
from half_field_world.game import HalfFieldReferee, half_field, set_up
from half_field_world.parameters import HalfFieldParameters
from hitab_world.inprocess import play
from hitab_world.testing import Wandering, check_world
from hitab_world.world import Placement
from keepaway_world.parameters import ParameterError

QUIET = {"movement_noise": 0.0, "kick_noise": 0.0, "turn_noise": 0.0}
AWAY = {
    **{f"attacker_{i + 1}": (-20.0, 10.0 * i) for i in range(3)},
    **{f"defender_{i + 1}": (-20.0, -10.0 - 5.0 * i) for i in range(2)},
    "goalie": (20.0, -30.0),
}
KICK = [3.0, 100.0, 0.0]


def game(**figures):
    """A game without noise, in which all stand far from the goal and the ball."""
    world = half_field(HalfFieldParameters(**{**QUIET, **figures}), seed=1)
    put(world, ball=(0.0, 0.0), **AWAY)
    return world


def put(world, **places):
    """Place things: ``name=(x, y)`` or ``name=(x, y, vx, vy)``, in m/cycle, facing the goal."""
    world.place(
        [
            Placement(name, *place[:2], 0.0, *(10.0 * v for v in (*place, 0.0, 0.0)[2:4]))
            for name, place in places.items()
        ]
    )


def ending(world, cycles, **actions):
    """Return why the episode ends within some cycles, or ""."""
    for _ in range(cycles):
        if world.step({name: (values, "") for name, values in actions.items()}):
            break
    return world.ended


def test_half_field_attack_is_a_world():
    wandering = Wandering([[], [1.0, 100.0], [2.0, 0.5], [3.0, 60.0, 1.0]], say=["pass 2"])
    check_world(lambda seed: half_field(HalfFieldParameters(offside=True), seed), wandering)


@pytest.mark.parametrize(
    ("place", "ended"),
    [
        ((26.0, 6.9, 1.0, 0.0), "goal"),
        ((26.0, -6.9, 1.0, 0.0), "goal"),
        ((26.0, 7.2, 1.0, 0.0), "out"),
        ((26.0, 6.8, 1.0, 0.9), "out"),  # crosses the line outside
        ((0.0, 33.9, 0.0, 1.0), "out"),
        ((-26.2, 0.0, -1.0, 0.0), "out"),
        ((26.0, 0.0, 0.1, 0.0), ""),  # not all of the ball
    ],
)
def test_a_ball_behind_a_line_is_a_goal_or_out(place, ended):
    world = game()
    put(world, ball=place)
    assert ending(world, 1) == ended
    assert world.result().measures["goals"] == float(ended == "goal")


def test_the_goalie_catches_a_ball_within_reach_in_its_area_and_nowhere_else():
    world = game()
    put(world, goalie=(20.0, 0.0), ball=(21.15, 0.0))
    assert ending(world, 1) == "caught"
    world = game()
    put(world, goalie=(20.0, 21.0), ball=(20.0, 22.0))
    assert ending(world, 1) == ""


def test_a_ball_that_a_defender_holds_is_taken():
    world = game()
    put(world, defender_1=(0.0, 0.8))
    assert ending(world, 5) == "taken"


def test_an_episode_ends_at_its_time_limit():
    world = game(time_limit=7, taker_speed=0.0)
    assert ending(world, 20) == "time"
    assert world.episode_cycle == 7


@pytest.mark.parametrize(
    ("counts", "x", "ended"), [(1, 5.0, "offside"), (1, -1.0, ""), (0, 5.0, "")]
)
def test_a_mate_in_an_offside_position_must_not_come_near_a_passed_ball(counts, x, ended):
    world = game(offside=bool(counts), taker_speed=0.0)
    put(world, attacker_1=(-0.7, 0.0), attacker_2=(x, 1.0), goalie=(24.0, 20.0))
    assert ending(world, 3, attacker_1=KICK) == ended


def test_an_attacker_behind_the_last_defender_is_onside():
    world = game(offside=True, taker_speed=0.0)
    put(world, attacker_1=(-0.7, 0.0), attacker_2=(5.0, 1.0), defender_1=(10.0, 30.0))
    assert ending(world, 3, attacker_1=KICK) == ""


def test_any_attacker_may_begin_at_the_ball_and_all_begin_apart():
    world, first = game(), set()
    for draw in range(30):
        set_up(world.physics, Random(draw))
        ball = world.physics.ball
        away = [math.hypot(a.x - ball.x, a.y - ball.y) for a in world.physics.keepers]
        first.add(away.index(min(away)))
        assert sorted(away)[1] > 7.0
        assert all(d.x > 0.0 for d in world.physics.takers)
        assert HalfFieldReferee(world.physics).judge(world.physics) is None
    assert first == {0, 1, 2}


def test_the_opponents_take_or_catch_a_ball_that_nobody_plays():
    world = half_field(seed=5)
    results = play(world, {}, 10)
    assert {r.ended for r in results} <= {"taken", "caught"}


def test_the_goalie_holds_a_slow_shot_and_not_a_near_fast_one_in_the_corner():
    for x, y, vx, vy, ended in ((0.0, 0.0, 1.7, 0.0, "caught"), (16.0, 0.0, 2.4, 1.45, "goal")):
        world = game()
        put(world, goalie=(24.0, 0.0), ball=(x, y, vx, vy))
        assert ending(world, 40) == ended


def test_a_defender_marks_the_attacker_near_the_goal():
    world = game()
    put(
        world,
        attacker_1=(-10.0, 0.0),
        attacker_2=(12.0, 8.0),
        ball=(-10.8, 0.0),
        defender_1=(0.0, 0.0),
        defender_2=(10.0, 0.0),
    )
    ending(world, 12)
    near = [math.hypot(d.x - 12.0, d.y - 8.0) for d in world.physics.takers[:2]]
    assert near[1] < 2.5 < near[0]


def test_half_a_field_has_one_size():
    with pytest.raises(ParameterError, match="half a field"):
        HalfFieldParameters(width=40.0)
    assert field.in_area(20.0, 0.0)
