"""What attackers do and perceive with each of their words."""

import math

import pytest

from half_field_world.body import GOAL, SPOT, AttackerBody
from half_field_world.domain import DOMAIN
from half_field_world.game import half_field
from half_field_world.parameters import HalfFieldParameters
from hitab_core import Repertoire, Term
from hitab_world.inprocess import AutomatonPlayer, PolicyPlayer, play_on
from hitab_world.world import Placement

NAMES = ("attacker_2", "attacker_3", "defender_1", "defender_2", "goalie")


@pytest.fixture
def scene():
    """Make a quiet world whose opponents stand still, with things at places."""

    def make(**places):
        noise = dict.fromkeys(("movement_noise", "kick_noise", "turn_noise"), 0.0)
        world = half_field(HalfFieldParameters(**noise, taker_speed=0.0, sight="full"), seed=1)
        away = {name: (-25.0, 6.0 * number - 33.0) for number, name in enumerate(NAMES)}
        world.place(
            [
                Placement(name, *place[:2], (*place, 0.0)[2], 0.0, 0.0)
                for name, place in {**away, **places}.items()
            ]
        )
        return world

    return make


def doing(world, behavior, cycles, *places):
    """Have attacker_1 perform a behavior for some cycles; return the world's entities by name."""
    body = AttackerBody("attacker_1")
    pulse = DOMAIN.behaviors[behavior].pulse
    player = PolicyPlayer(body, lambda b: pulse(b, *places))
    play_on(world, {"attacker_1": player}, cycles_max=world.episode_cycle + cycles)
    return {thing.name: thing for thing in world.entities()}


def seeing(world):
    body = AttackerBody("attacker_1")
    body.sense(*world.percept("attacker_1"))
    return body


def test_an_attacker_meets_a_rolling_ball_and_stops_it(scene):
    world = scene(attacker_1=(0.0, 0.0), ball=(8.0, 8.0))
    world.place([Placement("ball", 8.0, 8.0, 0.0, 0.0, -15.0)])
    seen = doing(world, "MeetBall", 30)
    ball, me = seen["ball"], seen["attacker_1"]
    assert math.hypot(ball.x - me.x, ball.y - me.y) < 1.1
    assert math.hypot(ball.vx, ball.vy) < 1.5


def test_an_attacker_dribbles_to_the_goal_around_an_opponent(scene):
    world = scene(attacker_1=(-10.0, 0.0), ball=(-9.3, 0.0), defender_1=(-2.0, 0.0))
    seen = doing(world, "Dribble", 60)
    ball, me = seen["ball"], seen["attacker_1"]
    assert me.x > 8.0
    assert math.hypot(ball.x - me.x, ball.y - me.y) < 6.0


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_shot_goes_where_the_goalie_is_not(scene, side):
    world = scene(attacker_1=(14.0, 0.0), ball=(14.7, 0.0), goalie=(25.0, 2.0 * side))
    world.step({})
    seen = doing(world, "Shoot", 10)
    assert world.ended == "goal"
    assert seen["ball"].y * side < -2.0


def test_a_player_in_the_way_leaves_a_pass_no_room(scene):
    places = {"attacker_1": (0.0, 0.0), "ball": (0.7, 0.0), "attacker_2": (10.0, 0.0)}
    free = seeing(scene(**places))
    blocked = seeing(scene(**places, defender_1=(5.0, 0.5)))
    mate = free.others[0]
    assert free.line_to(mate).slack > 3.0
    assert blocked.line_to(mate).slack < 0.0


def test_the_best_mate_is_the_most_advanced_that_a_pass_reaches(scene):
    places = {
        "attacker_1": (0.0, 0.0),
        "ball": (0.7, 0.0),
        "attacker_2": (5.0, 10.0),
        "attacker_3": (12.0, -10.0),
    }
    body = seeing(scene(**places))
    assert body.number_at(body.best_mate()) == 3
    body = seeing(scene(**places, defender_1=(6.0, -5.0)))
    assert body.number_at(body.best_mate()) == 2


def test_an_attacker_runs_to_a_place_and_faces_the_ball_there(scene):
    world = scene(attacker_1=(0.0, 10.0), ball=(-10.0, -10.0))
    me = doing(world, "RunTo", 60, SPOT)["attacker_1"]
    assert math.hypot(me.x - 15.25, me.y) < 1.5
    off = math.atan2(-10.0 - me.y, -10.0 - me.x) - me.heading
    assert abs(math.remainder(off, 2.0 * math.pi)) < 0.1


def test_wings_are_on_the_balls_side_and_on_the_other(scene):
    body = seeing(scene(attacker_1=(0.0, 0.0), ball=(0.0, 5.0)))
    assert body.at(body.near_wing())[1] > 0.0 > body.at(body.far_wing())[1]
    assert body.at(GOAL) == (26.25, 0.0)


def test_keepers_words_work_for_attackers(scene):
    world = scene(attacker_1=(0.0, 0.0, 2.0), ball=(4.0, 3.0))
    player = AutomatonPlayer(Repertoire(DOMAIN), Term("ServoBall"), "attacker_1")
    play_on(world, {"attacker_1": player}, cycles_max=30)
    assert seeing(world).ball_is_kickable
