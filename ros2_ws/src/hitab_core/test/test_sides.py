"""Questions about the side of a circle on which a command was not shown."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from hitab_core import Agent, BehaviorLibrary, Feature, FeatureKind, Use, plain_domain
from hitab_core.advice.evidence import Evidence
from hitab_core.advice.sides import Circles, lone_values, unshown_sides
from hitab_core.domain import Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.training import Curriculum

CIRCLE = Scale(FeatureKind.TOROIDAL, 360.0)
WIND = Feature("Wind", lambda body: body.percept[0], FeatureKind.TOROIDAL, period=360.0)
DOMAIN = plain_domain("boat", ["Turn", "Sail"], [WIND, "Depth"])


def stay(*values: float) -> Example:
    return Example("Sail", values, "Sail", ExampleKind.DEFAULT)


def turn(*values: float) -> Example:
    return Example("Sail", values, "Turn", ExampleKind.DEMONSTRATED)


def asked(*examples: Example, readings=(), scales=(CIRCLE,), classifier="tree"):
    """Return where it is asked whether Turn is right, from -180 to 180."""
    names = ["Wind", "Depth"][: len(scales)]
    evidence = Evidence.of("Sail", examples, scales, names, (), classifier)
    rows = [[reading] for reading in readings]
    found = unshown_sides(Circles(evidence, rows, [True] * len(rows)))
    assert {(side.state, side.next_state) for side in found} <= {("Sail", "Turn")}
    return [round((side.situation[side.feature] + 180.0) % 360.0 - 180.0, 6) for side in found]


def lone(*examples: Example, readings=()):
    """Return where it is asked about a command at one value, from -180 to 180."""
    evidence = Evidence.of("Sail", examples, [CIRCLE], ["Wind"], ())
    rows = [[reading] for reading in readings]
    found = lone_values(Circles(evidence, rows, [True] * len(rows)))
    assert all(side.one_value for side in found)
    return [round((side.situation[0] + 180.0) % 360.0 - 180.0, 6) for side in found]


AMONG = (stay(-120.0), turn(0.09), stay(60.0))


def test_a_command_at_one_value_is_asked_about_where_the_robot_came_from():
    assert lone(*AMONG, readings=[50.0, 30.0, 10.0, 3.0]) == [6.09]
    assert lone(*AMONG, readings=[-50.0, -30.0, -10.0]) == [-5.91]


def test_a_sensor_that_rounds_meets_the_value_again():
    assert lone(*AMONG, readings=[5.0, 0.09, 2.0]) == []
    assert lone(*AMONG, turn(0.09), readings=[5.0, 2.0]) == [6.09], "two commands are no meeting"


def test_a_command_at_two_values_or_for_a_side_holds_for_more():
    assert lone(*AMONG, turn(3.0)) == []
    assert lone(stay(0.0), turn(20.0)) == []


def test_after_the_answer_to_stay_it_is_asked_nearer_until_it_is_exact():
    examples, places = [*AMONG], []
    while found := lone(*examples, readings=[50.0, 30.0, 10.0]):
        places += found
        examples.append(stay(found[0]))
    assert places == pytest.approx([6.09, 3.09, 1.59, 0.84])
    answered = lone(*AMONG, turn(6.09), readings=[50.0, 30.0])
    assert answered == [], "now it holds from there to the command"


@pytest.mark.parametrize("zero", [0.0, 90.0, 175.0, 355.0])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_command_on_one_side_is_asked_about_as_far_on_the_other(zero, sign):
    (place,) = asked(stay(zero), turn((zero + sign * 10.0) % 360.0))
    assert (place - zero) % 360.0 == pytest.approx(-sign * 10.0 % 360.0)


def test_what_was_shown_on_both_sides_is_not_asked_about():
    assert asked(stay(0.0), turn(10.0), turn(-30.0)) == []


def test_default_examples_on_both_sides_leave_no_side():
    assert asked(stay(20.0), turn(2.0), stay(-30.0), stay(170.0)) == []


def test_after_the_answer_to_stay_it_is_asked_farther_on_up_to_a_quarter_of_the_circle():
    examples, places = [stay(0.0), turn(10.0)], []
    while found := asked(*examples):
        places += found
        examples.append(stay(found[0]))
    assert places == [-10.0, -20.0, -40.0, -80.0]


def test_a_command_beyond_a_quarter_of_the_circle_does_not_mean_a_side():
    assert asked(stay(0.0), turn(120.0)) == []


def test_where_an_agent_never_is_nothing_is_asked():
    examples = stay(0.0), turn(10.0)
    assert asked(*examples, readings=[5.0] * 10) == [-10.0], "too few to know"
    assert asked(*examples, readings=[5.0] * 40) == []
    assert asked(*examples, readings=[*[5.0] * 40, -50.0]) == [-10.0]


def test_nothing_is_asked_about_other_features_than_those_that_decide():
    scales = (CIRCLE, Scale())
    assert asked(stay(0.0, 8.0), turn(0.0, 2.0), scales=scales) == []
    assert asked(stay(0.0, 2.0), turn(10.0, 2.0), scales=scales) == [-10.0]
    assert asked(stay(8.0), turn(2.0), scales=(Scale(),)) == [], "a line"
    assert asked(stay(math.nan), turn(10.0)) == []


def test_of_other_classifiers_than_trees_nothing_is_asked():
    other = "sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)"
    assert asked(stay(0.0), turn(10.0), classifier=other) == []


@pytest.fixture
def boat(tmp_path: Path) -> Agent:
    """Sails with the wind from ahead, and turns for wind from 12 degrees, 5 m of water below."""
    agent = Agent("boat", DOMAIN, BehaviorLibrary(tmp_path / "library", DOMAIN), tmp_path / "log")
    agent.begin(Curriculum("Cruise", (Use("Wind"), Use("Depth"))))
    for cycle, (wind, label) in enumerate(((0.0, "Sail"), (12.0, "Turn"))):
        agent.sense([wind, 5.0], [], cycle, cycle * 0.1)
        agent.tick()
        agent.command(Use(label))
    return agent


def test_one_answer_shows_the_other_side_and_can_be_undone(boat):
    session = boat.session
    (question,) = session.questions()
    assert question.kind == "sparse"
    assert question.text == (
        "In Sail, you showed Turn on one side only, at Wind = 12. "
        "Is it right on the other side, too, with Wind = -12?"
    )
    assert question.examples == (3,)
    assert question.situation == (348.0, 5.0)
    assert [(c.name, c.effect) for c in question.choices] == [
        ("Turn", "adds an example: go to Turn there"),
        ("Sail", "adds an example: stay in Sail there"),
    ]
    session.answer(question.number)
    function = session.automaton().transitions["Sail"]
    winds = (0.0, 5.0, 12.0, 90.0, 180.0, 270.0, 348.0, 355.0)
    turned = [str(function.predict([[wind, 5.0]])[0]) == "Turn" for wind in winds]
    assert turned == [False, False, True, True, True, True, True, False]
    assert session.questions() == []
    session.undo()
    assert [q.number for q in session.questions()] == [question.number]


def test_the_question_farther_on_is_another_one_and_dismissing_it_ends_all(boat):
    session = boat.session
    (question,) = session.questions()
    session.answer(question.number, "Sail")
    (farther,) = session.questions()
    assert farther.number != question.number
    assert farther.situation == (336.0, 5.0)
    session.answer(farther.number, dismiss=True)
    assert session.questions() == []
    session.undo()
    assert session.questions() == [], "not about the same side"
