"""The shipped lessons leave little ambiguous, and answers settle it.

`ControlBall` is right only because ties prefer boolean features: in its examples the ball becomes
kickable just when a taker has come near. Without this rule it learns to stop chasing the ball when
a taker comes near.
"""

from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest

import keepaway_world
from hitab_core.advice.ambiguity import ambiguities
from hitab_core.advice.evidence import Evidence
from hitab_core.automaton import FLAGS
from hitab_core.domain import BOOLEAN_SCALE
from hitab_core.library.behavior_library import BehaviorLibrary
from keepaway_world.domain import DOMAIN

LIBRARY = Path(keepaway_world.__file__).parents[1] / "libraries" / "keepaway"
NO_RULE = "tree(boolean_first=False)"

TAKERS = [0.5 + i / 2 for i in range(28)]
"""Distances of a taker, m."""

SITUATIONS = [list(map(float, pair)) for pair in product(TAKERS, (0, 1))]


@pytest.fixture(scope="module")
def automata():
    """Return the automata of the paper's set."""
    return BehaviorLibrary(LIBRARY, DOMAIN).load()


def evidence(automaton, state, classifier):
    """Return the examples of a state of an automaton."""
    words = [DOMAIN.features.get(use.name) for use in automaton.features]
    return Evidence.of(
        state,
        automaton.examples,
        [BOOLEAN_SCALE if word is None else word.scale for word in words],
        [str(use) for use in automaton.features],
        ["" if word is None else word.unit for word in words],
        classifier,
    )


def asked(given, perceived, shipped):
    """Return the questions that come, each answered as the shipped automaton decides, and then."""
    questions = []
    while open_questions := ambiguities(given, perceived):
        question = open_questions[0]
        questions.append(question)
        (answer,) = shipped.predict([question.situation])
        given = given.with_answer(question.situation, str(answer))
        assert len(questions) < 10
    return questions, given


def situations_seen(automaton):
    """Return the states and values of all examples of an automaton."""
    return [(example.state, example.features) for example in automaton.examples]


@pytest.mark.parametrize("state", ["GotoBall", "Stop"])
def test_control_ball_asks_without_the_tie_rule_and_answered_it_is_the_shipped_one(
    automata, state
):
    automaton = automata["ControlBall"]
    given = evidence(automaton, state, NO_RULE)
    shipped = evidence(automaton, state, "tree").learn()
    wrong = given.learn().predict(SITUATIONS) != shipped.predict(SITUATIONS)
    assert wrong.any()
    (question,), answered = asked(given, situations_seen(automaton), shipped)
    texts = {side.because for side in (question.learned, question.other)}
    near = "DistanceTo(closest_taker) "
    assert any("BallIsKickable" in text for text in texts)
    assert any(text.startswith(near) for text in texts)
    assert {side.next_state for side in (question.learned, question.other)} == {
        "GotoBall",
        {"GotoBall": "Stop", "Stop": "Pass"}[state],
    }
    decisions = answered.learn().predict(SITUATIONS)
    assert decisions.tolist() == shipped.predict(SITUATIONS).tolist()


def test_it_asks_the_same_with_the_tie_rule_and_answers_change_no_decision(automata):
    automaton = automata["ControlBall"]
    for state in ("GotoBall", "Stop"):
        seen = situations_seen(automaton)
        with_rule = evidence(automaton, state, "tree")
        shipped = with_rule.learn()
        questions, answered = asked(with_rule, seen, shipped)
        without, _ = asked(replace(with_rule, classifier=NO_RULE), seen, shipped)
        assert [question.key for question in questions] == [question.key for question in without]
        assert (answered.learn().predict(SITUATIONS) == shipped.predict(SITUATIONS)).all()


def test_the_other_lessons_leave_nothing_to_ask(automata):
    for name in sorted(set(automata) - {"ControlBall"}):
        for state in dict.fromkeys(example.state for example in automata[name].examples):
            if state not in FLAGS:
                given = evidence(automata[name], state, "tree")
                assert asked(given, situations_seen(automata[name]), None)[0] == []
