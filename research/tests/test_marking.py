"""Takers that are not needed at the ball mark, as UT Austin's do."""

import math
from dataclasses import replace

import pytest

from keepaway_research.reference.marking import mark
from keepaway_research.reference.prediction import Motion, Predictor
from keepaway_research.reference.takers import ReferenceTaker
from keepaway_research.reference.view import Seen, View
from keepaway_world.parameters import variant
from keepaway_world.world import KeepawayWorld

GAME = variant("standard", keepers=4, takers=3, width=25.0, height=25.0, taker_policy="reference")
FORWARD = -1.0


def at(name: str, x: float, y: float, heading: float = 0.0) -> Seen:
    return Seen(name, x, y, 0.0, 0.0, heading)


def seen(me: str, **places: tuple[float, float]) -> View:
    """Return what a taker sees; keepers are k1, ..., takers t1, ..."""
    everybody = {name: at(name, *place) for name, place in places.items()}
    keepers = [player for name, player in everybody.items() if name[0] == "k"]
    takers = [player for name, player in everybody.items() if name[0] == "t"]
    return View(GAME, everybody[me], everybody["ball"], keepers, takers)


def test_who_marks_comes_to_stand_between_keeper_and_ball_and_looks_aside():
    for heading in [0.0, 1.0, 3.0, -2.0]:
        predictor = Predictor(GAME)
        keeper, ball = at("k2", 8.0, 0.0), at("ball", -8.0, 0.0)
        motion = Motion(complex(0.0, 9.0), 0j, heading)
        for _ in range(60):
            me = Seen("t3", motion.position.real, motion.position.imag, 0.0, 0.0, motion.heading)
            me.vx, me.vy = motion.velocity.real, motion.velocity.imag
            motion = predictor.after(motion, mark(predictor, me, keeper, ball, FORWARD))
        place = complex(8.0 + 1.0 - 4.0, 0.0)  # where it is expected, 4 m towards the ball
        assert abs(motion.position - place) < 2.0
        to_keeper = math.atan2(-motion.position.imag, 8.0 - motion.position.real)
        assert abs(math.remainder(motion.heading - to_keeper, 2.0 * math.pi)) == pytest.approx(
            math.radians(80.0), abs=0.05
        )


def test_two_takers_go_for_the_ball_and_the_third_marks():
    places = {
        "ball": (0.0, 0.0),
        **{"k1": (0.5, 0.0), "k2": (10.0, 10.0), "k3": (10.0, -10.0), "k4": (-10.0, 0.0)},
        **{"t1": (0.0, 5.0), "t2": (0.0, 6.0), "t3": (0.0, 9.0)},
    }

    def decided(me: str):
        return ReferenceTaker(GAME).decide(seen(me, **places), 1)

    ball = math.atan2(-1.0, 0.0)  # seen from all of the takers
    for name in ("t1", "t2"):
        kind, amount, _ = decided(name)
        assert (kind, amount) == ("turn", pytest.approx(ball, abs=0.02))
    kind, amount, _ = decided("t3")
    assert kind == "turn"
    # Nobody is in any keeper's lane: it marks the last one, which is at (-10, 0).
    expected = -10.0 + 1.0
    assert amount == pytest.approx(math.atan2(-9.0, expected + 4.0), abs=0.02)


@pytest.mark.parametrize(("policy", "near"), [("intercept", True), ("reference", False)])
def test_only_takers_that_mark_leave_one_away_from_the_ball(policy, near):
    world = KeepawayWorld(replace(GAME, taker_policy=policy), 5)
    apart = []
    for _ in range(200):
        if world.ended:
            apart.append(third_from_ball(world))
            world.reset()
        world.step({})
    assert len(apart) > 3
    assert (sum(apart) / len(apart) < 3.0) == near


def third_from_ball(world: KeepawayWorld) -> float:
    """Return how far the third taker is from the ball, m."""
    ball, *others = world.entities()
    takers = [e for e in others if e.name.startswith("taker")]
    return sorted(math.hypot(t.x - ball.x, t.y - ball.y) for t in takers)[2]
