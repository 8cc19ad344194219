"""Numbers of behaviors that are learned by regression from moments shown."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from hitab_core import (
    BasicBehavior,
    BoundedNumber,
    Domain,
    Feature,
    FeatureKind,
    LearningAgent,
    LibraryError,
    Scale,
    Term,
    VocabularyError,
    numbers_of,
)
from hitab_core.library import BehaviorFile
from hitab_core.plain_body import PlainBody
from hitab_core.regression import MOMENTS_MAX, Neighbors

DIRECTION = BoundedNumber("direction", -180.0, 180.0, "deg", circular=True)
SPEED = BoundedNumber("speed", 0.0, 1.0, "m/s")
CIRCLE = Scale(FeatureKind.TOROIDAL, 2 * math.pi)


class Boat(PlainBody):
    def steer(self, *numbers):
        self.action = list(numbers)


BOAT = Domain.of(
    "boat",
    "1",
    Boat,
    behaviors=[
        BasicBehavior("Sail", Boat.steer, numbers=(DIRECTION, SPEED)),
        BasicBehavior("Anchor", lambda boat: boat.steer(0.0), stands_still=True),
    ],
    features=[
        Feature("Wind", lambda boat: boat.percept[0], FeatureKind.TOROIDAL),
        Feature("Depth", lambda boat: boat.percept[1], unit="m"),
    ],
)


def trained(folder=None):
    agent = LearningAgent(BOAT, folder).train("Cruise")
    agent.step([0.0, 9.0], command="Sail(direction=170, speed=1)")
    agent.step([1.0, 9.0], command="Sail(direction=-170, speed=0.5)")
    agent.step([1.0, 1.0], command="Anchor")
    return agent


def test_a_command_gives_the_numbers_until_the_next_command():
    agent = LearningAgent(BOAT).train("Cruise")
    assert agent.step([0.0, 9.0], command="Sail(direction=40, speed=1)") == (40.0, 1.0)
    assert agent.step([2.0, 5.0]) == (40.0, 1.0)
    assert agent.step([2.0, 5.0], command="Sail(direction=10, speed=0.5)") == (10.0, 0.5)


def test_what_is_learned_answers_as_shown_and_between_it():
    agent = trained()
    agent.learn()
    assert agent.step([0.0, 9.0]) == pytest.approx((170.0, 1.0))
    direction, speed = agent.step([0.5, 9.0])
    assert (abs(direction), speed) == (pytest.approx(180.0), pytest.approx(0.75))
    assert agent.step([1.0, 1.0]) == (0.0,)


def test_a_correction_changes_the_numbers_and_undo_takes_it_back():
    agent = trained()
    agent.learn()
    before = agent.step([0.5, 9.0])
    agent.step([0.5, 9.0], command="Sail(direction=90, speed=0)")
    agent.learn()
    assert agent.step([0.5, 9.0]) == pytest.approx((90.0, 0.0))
    agent.agent.session.undo()
    assert agent.step([0.5, 9.0]) == pytest.approx(before)


def test_a_moment_can_be_relabeled_with_other_numbers():
    agent = trained()
    agent.agent.session.relabel([1], Term.parse("Sail(direction=20, speed=0.25)"))
    agent.learn()
    assert agent.step([0.0, 9.0]) == pytest.approx((20.0, 0.25))


def test_numbers_are_saved_as_data_and_learned_again_from_the_file(tmp_path):
    agent = trained(tmp_path)
    agent.save()
    text = (tmp_path / "Cruise.hfa.yaml").read_text()
    assert "{example: 1, values: [170.0, 1.0]}" in text
    again = LearningAgent(BOAT, tmp_path)
    again.perform("Cruise")
    assert again.step([0.0, 9.0]) == pytest.approx((170.0, 1.0))
    (tmp_path / "Cruise.hfa.yaml").write_text(text.replace("170.0, 1.0", "170.0, 2.0"))
    with pytest.raises(LibraryError, match="has 2 as speed; give speed from 0 to 1 m/s"):
        agent.agent.library.load()


def test_what_was_learned_differs_if_only_a_number_does(tmp_path):
    digests = set()
    for speed in (1.0, 0.5, 1.0):
        agent = LearningAgent(BOAT, tmp_path / f"{len(digests)}").train("Cruise")
        agent.step([0.0, 9.0], command=f"Sail(direction=170, speed={speed})")
        agent.save()
        file: BehaviorFile = agent.agent.library.file("Cruise")
        digests.add(file.learned)
    assert len(digests) == 2


@pytest.mark.parametrize(
    ("command", "wrong"),
    [
        ("Sail(direction=200, speed=1)", "direction .* is 200; give direction from -180 to 180"),
        ("Sail(direction=nan, speed=1)", "direction .* is nan; give direction from -180 to 180"),
        ("Sail(direction=1)", r'"Sail" needs speed from 0 to 1 m/s'),
        ("Sail(course=1, speed=1)", r'unknown number "course" in .*direction'),
        ("Anchor(speed=1)", 'unknown number "speed"'),
        ("Sail(speed=1, speed=1)", "gives speed twice"),
    ],
)
def test_wrong_numbers_are_refused_and_teach_nothing(command, wrong):
    agent = trained()
    with pytest.raises(VocabularyError, match=wrong):
        agent.step([0.0, 9.0], command=command)
    assert len(agent.agent.session.examples) == 5


@pytest.mark.parametrize(
    "arguments", [(), ("40",), ("speed=0.2",), ("direction=200",), ("direction=3", "speed=x")]
)
def test_the_example_of_a_refusal_is_not_refused(arguments):
    wanted = BOAT.numbers_of(Term("Sail"))
    with pytest.raises(VocabularyError) as refused:
        numbers_of(Term("Sail", arguments), wanted)
    example = Term.parse(str(refused.value).rpartition("for example ")[2])
    assert numbers_of(example, wanted)[1] == (0.2 if "speed=0.2" in arguments else 0.5)
    trained().step([0.0, 9.0], command=str(example))


def test_a_situation_without_any_value_does_nothing():
    shown = Neighbors([[0.0]], [[1.0]], [Scale()], [SPEED])
    assert shown([math.nan]) == ()
    assert shown.distance([math.nan]) == math.inf


def test_it_knows_how_far_it_is_from_what_was_shown():
    shown = Neighbors([[0.0], [1.0], [2.0]], [[0.0], [0.5], [1.0]], [Scale()], [SPEED])
    assert shown.distance([1.0]) == 0.0
    assert shown.distance([9.0]) == pytest.approx(7.0)
    assert [moment.example for moment in shown.nearest([1.9])] == [2, 1, 0]
    assert 0.5 < shown([1e9])[0] <= 1.0


def test_an_unsure_agent_does_not_steer_far_from_the_moments_shown():
    from hitab_core import Caution, WhenUnsure

    agent = trained()
    agent.learn()
    agent.agent.monitor.set(Caution(WhenUnsure.HALT, distance=3.0))
    assert agent.step([0.5, 9.0])
    assert agent.step([0.5, 900.0]) == ()
    assert agent.agent.monitor.unsure


def test_an_unsure_agent_does_nothing_in_the_tick_that_enters_a_state_far_from_its_moments():
    from hitab_core import Caution, WhenUnsure

    agent = trained()
    agent.step([1.0, 900.0], command="Anchor")
    agent.step([1.0, 9.0], command="Sail(direction=0, speed=1)")
    for distance, sailed in ((1e6, 2), (3.0, 0)):
        agent.learn()
        agent.agent.monitor.set(Caution(WhenUnsure.HALT, distance))
        assert agent.step([0.0, 9.0])
        assert agent.step([1.0, 1.0]) == (0.0,)
        assert len(agent.step([1.0, 300.0])) == sailed
        assert agent.agent.active_path == ["Sail"]
    assert "nearest moment whose numbers were shown" in agent.agent.monitor.unsure
    assert agent.step([1.0, 9.0])
    assert agent.agent.monitor.unsure == ""


def test_a_behavior_that_lacks_numbers_is_stopped_and_begins_again():
    from hitab_core import Caution, WhenUnsure

    done = []
    sail = BasicBehavior(
        "Sail",
        Boat.steer,
        start=lambda boat: done.append("start"),
        stop=lambda boat: done.append("stop"),
        numbers=(DIRECTION, SPEED),
    )
    boat = Domain.of("b", "1", Boat, behaviors=[sail], features=list(BOAT.features.values()))
    agent = LearningAgent(boat).train("Cruise")
    agent.step([0.0, 9.0], command="Sail(direction=170, speed=1)")
    agent.step([1.0, 9.0], command="Sail(direction=170, speed=0.5)")
    agent.learn()
    agent.agent.monitor.set(Caution(WhenUnsure.HALT, 3.0))
    done.clear()
    for depth in (9.0, 900.0, 900.0, 9.0):
        agent.step([0.0, depth])
    assert done == ["start", "stop", "start"]


@given(some.integers(0, 2**32 - 1), some.integers(1, 40))
def test_numbers_are_those_of_scikit_learns_neighbors(seed, count):
    from sklearn.neighbors import KNeighborsRegressor

    random = np.random.default_rng(seed)
    rows, numbers = random.normal(size=(count, 3)), random.uniform(0, 1, (count, 1))
    shown = Neighbors(rows, numbers, [Scale()] * 3, [SPEED])
    usual = np.array([_median_difference(column) for column in rows.T])
    theirs = KNeighborsRegressor(min(3, count), weights="distance").fit(rows / usual, numbers)
    place = random.normal(size=3)
    assert shown(place)[0] == pytest.approx(theirs.predict([place / usual])[0, 0], abs=1e-9)


def _median_difference(column):
    apart = np.abs(column[:, None] - column)
    return np.median(apart[apart > 0]) if len(column) > 1 else 1.0


@given(some.floats(-20.0, 20.0), some.floats(-20.0, 20.0))
def test_circles_have_no_seam(place, other):
    shown = Neighbors([[other], [0.3]], [[179.0], [-179.0]], [CIRCLE], [DIRECTION])
    direction = shown([place])[0]
    assert abs(direction) >= 179.0 - 1e-6
    assert shown([place + 2 * math.pi])[0] == pytest.approx(direction, abs=1e-3)


def test_thirty_thousand_moments_are_thinned_out_and_stay_right():
    random = np.random.default_rng(5)
    rows = random.uniform(-1.0, 1.0, (30_000, 2))
    numbers = (rows[:, :1] + 1.0) / 2.0
    shown = Neighbors(rows, numbers, [Scale()] * 2, [SPEED])
    assert {moment.example for moment in shown.nearest([0.1, 0.1])} <= set(range(30_000))
    off = [abs(shown(row)[0] - (row[0] + 1.0) / 2.0) for row in rows[:200]]
    assert np.mean(off) < 0.02
    assert (
        len({moment.example for row in rows[::10] for moment in shown.nearest(row)}) <= MOMENTS_MAX
    )


def test_an_answer_is_explained_by_the_examples_that_it_comes_from():
    agent = trained()
    numbers = agent.learn().numbers["Sail"]
    nearest = numbers.nearest([0.9, 9.0])
    assert [moment.example for moment in nearest] == [3, 1]
    assert sum(moment.weight for moment in nearest) == pytest.approx(1.0)


def test_what_takes_numbers_is_composed_like_any_behavior(tmp_path):
    agent = trained(tmp_path)
    agent.save()
    agent.train("Voyage").step([0.0, 9.0], command="Cruise")
    agent.learn()
    assert agent.step([0.0, 9.0]) == pytest.approx((170.0, 1.0))
