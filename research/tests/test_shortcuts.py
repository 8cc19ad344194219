"""What is left out to save time changes nothing: results are those of the long way, to the bit."""

import math
from random import Random

import pytest

from keepaway_research.fullspeed import supporting
from keepaway_research.fullspeed.body import FullSpeedBody
from keepaway_research.predictive.forecast import COMFORTABLE, HORIZON, Forecaster
from keepaway_research.reference.prediction import Motion, Predictor
from keepaway_world.parameters import PAPER, variant
from keepaway_world.percept import percept_length

CASES = 400


@pytest.fixture
def random():
    return Random(5)


def test_where_a_player_ends_up_is_where_its_moves_take_it(random):
    predictor = Predictor(PAPER)
    near = 0
    for _ in range(CASES):
        motion = Motion(
            complex(random.uniform(-9, 9), random.uniform(-9, 9)),
            complex(random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)),
            random.uniform(-math.pi, math.pi),
        )
        reach = random.choice((1.0, 4.0, 12.0, 25.0))
        target = motion.position + complex(
            random.uniform(-reach, reach), random.uniform(-reach, reach)
        )
        cycles = random.randrange(0, 25)
        away = abs(predictor.moved_to(motion, target, cycles).position - target)
        found = predictor.missed_by(motion, target, cycles, PAPER.kickable)
        assert found == away or (found == math.inf and away >= PAPER.kickable)
        near += away < PAPER.kickable
    assert near > CASES / 10


def test_the_soonest_cycle_to_meet_the_ball_is_that_of_trying_all(random):
    forecaster, size = Forecaster(PAPER), (20.0, 20.0)
    for _ in range(CASES):
        ball = random.uniform(-11, 11), random.uniform(-9, 9)
        speed = random.choice((0.0, 0.5, 2.5))
        velocity = random.uniform(-speed, speed), random.uniform(-speed, speed)
        track = forecaster.track(ball, velocity, size)
        position = random.uniform(-9, 9), random.uniform(-9, 9)
        reached = (
            cycles
            for cycles, place in enumerate(track)
            if math.hypot(place[0] - position[0], place[1] - position[1]) - COMFORTABLE
            <= forecaster._run[cycles]
        )
        beyond = HORIZON + math.ceil(math.dist(track[-1], position))
        assert forecaster.cycles_to_meet(position, track) == next(reached, beyond)


@pytest.mark.parametrize(("keepers", "takers"), [(3, 2), (4, 3)])
def test_the_best_place_is_that_of_judging_all(random, monkeypatch, keepers, takers):
    game = variant("standard", keepers=keepers, takers=takers)
    for _ in range(CASES // 8):
        body = FullSpeedBody("keeper_1", game)
        values = [random.uniform(0.5, 12.0) for _ in range(percept_length(keepers, takers))]
        values[:10] = [1, keepers, takers, 20, 20, random.uniform(-8, 8), 3, 0, 2, 1]
        body.sense(values, [])
        body.aim = random.choice((None, (-7.5, 7.5), (1.5, 1.5)))
        found = supporting.best_place(body)
        with monkeypatch.context() as patched:
            patched.setattr(supporting, "_is_worth_less", lambda *of_place: False)
            patched.setattr(supporting, "ROUNDING", 1e9)
            assert found == supporting.best_place(body)
