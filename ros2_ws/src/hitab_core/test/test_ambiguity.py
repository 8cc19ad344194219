"""Questions about examples that several explanations fit, and what the answers do."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_core.advice.ambiguity import alternatives, ambiguities
from hitab_core.advice.evidence import Evidence
from hitab_core.domain import BOOLEAN_SCALE, FeatureKind, Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.learning import Leaf
from hitab_core.learning.tree_nodes import nodes

METERS = Scale()
DEGREES = Scale(FeatureKind.TOROIDAL, 360.0)
NAMES = ("Taker", "Kickable")
SCALES = (METERS, BOOLEAN_SCALE)
UNITS = ("m", "")

# The state GotoBall of ControlBall: chase the ball while it cannot be kicked.
CHASING = [
    ("Go", (12.0, 0.0), "Go", True),
    ("Go", (8.0, 1.0), "Stop", False),
]


def evidence(rows, scales=SCALES, names=NAMES, units=UNITS, classifier="tree"):
    """Return the evidence of rows (state, values, next state, is default)."""
    examples = [
        Example(
            state, values, goes_to, ExampleKind.DEFAULT if default else ExampleKind.DEMONSTRATED
        )
        for state, values, goes_to, default in rows
    ]
    return Evidence.of(rows[0][0], examples, scales, names, units, classifier)


def seen(*readings):
    """Return what was perceived in another state."""
    return [("At", values) for values in readings]


def decisions(known, situations):
    """Return what is learned to do in some situations."""
    return known.learn().predict(situations).tolist()


@pytest.mark.parametrize("boolean_first", [True, False])
def test_a_tie_is_asked_about_in_a_situation_that_was_seen(boolean_first):
    known = evidence(CHASING, classifier=f"tree(boolean_first={boolean_first})")
    (question,) = ambiguities(known, [("At", (12.5, 1.0)), ("Go", (11.0, 0.0))])
    sides = [question.learned, question.other]
    kickable, taker = sides if boolean_first else sides[::-1]
    assert (kickable.next_state, kickable.because) == ("Stop", "Kickable")
    assert (taker.next_state, taker.because) == ("Go", "Taker > 8 m")
    assert question.situation == (12.5, 1.0)
    assert not question.here
    assert question.text.startswith("In Go with Taker = 12.5 m, Kickable: ")


@pytest.mark.parametrize("side", ["learned", "other"])
@pytest.mark.parametrize("boolean_first", [True, False])
def test_the_answer_makes_the_tree_take_the_right_split(boolean_first, side):
    known = evidence(CHASING, classifier=f"tree(boolean_first={boolean_first})")
    readings = seen([12.5, 1.0], [3.0, 0.0])
    question, *_ = ambiguities(known, readings)
    answer = getattr(question, side)
    answered = known.with_answer(question.situation, answer.next_state)
    assert answered.learn().features_used == (answer.feature,)
    assert ambiguities(answered, readings) == []


def test_nothing_is_asked_where_one_explanation_is_better():
    rows = [*CHASING, ("Go", (9.0, 0.0), "Go", False), ("Go", (7.0, 0.0), "Go", False)]
    assert ambiguities(evidence(rows), seen([12.5, 1.0], [3.0, 0.0])) == []


def test_nothing_is_asked_where_the_explanations_never_differ():
    readings = [("Go", (9.0 + i / 10, 0.0)) for i in range(30)]
    readings += [("Go", (8.0 - i / 10, 1.0)) for i in range(30)]
    known = evidence(CHASING)
    assert len(alternatives(known)[1]) == 1
    assert ambiguities(known, readings) == []


def test_readings_of_the_state_itself_come_first():
    known = evidence(CHASING)
    (question,) = ambiguities(known, [("At", (12.0, 1.0)), ("Go", (14.0, 1.0))])
    assert (question.here, question.situation) == (True, (14.0, 1.0))
    assert question.share == pytest.approx(1 / 3)  # of two examples and one reading


def test_one_situation_serves_all_explanations_that_it_tells_apart():
    scales, names = (BOOLEAN_SCALE,) * 3, ("A", "B", "C")
    rows = [("S", (0.0, 0.0, 0.0), "S", True), ("S", (1.0, 1.0, 1.0), "T", False)]
    known = evidence(rows, scales, names, ("",) * 3)
    assert len(alternatives(known)[1]) == 2
    both = ambiguities(known, seen([1.0, 0.0, 0.0]))
    assert len(both) == 1
    apart = ambiguities(known, seen([1.0, 0.0, 1.0], [1.0, 1.0, 0.0]))
    assert len(apart) == 2


def test_a_question_is_recognized_again_after_more_examples():
    before = ambiguities(evidence(CHASING), seen([12.5, 1.0]))[0]
    more = [*CHASING, ("Go", (11.5, 0.0), "Go", True)]
    after = ambiguities(evidence(more), seen([13.0, 1.0]))[0]
    swapped = evidence(CHASING, classifier="tree(boolean_first=False)")
    assert before.key == after.key == ambiguities(swapped, seen([12.5, 1.0]))[0].key
    assert before.key[0] == "Go"


def test_a_single_direction_is_no_explanation():
    scales, names = (METERS, DEGREES), ("Ball", "Bearing")
    rows = [
        ("S", (9.0, 10.0), "S", True),
        ("S", (3.0, 20.0), "T", False),
        ("S", (9.5, 30.0), "S", True),
    ]
    assert alternatives(evidence(rows, scales, names))[1] == []


def test_the_alternative_of_two_tests_is_their_other_order():
    # Stop of ControlBall: lost the ball, or a taker is near.
    rows = [
        ("Stop", (8.0, 1.0), "Stop", True),
        ("Stop", (2.5, 1.0), "Pass", False),
        ("Stop", (12.0, 1.0), "Stop", True),
        ("Stop", (12.0, 0.0), "Go", False),
    ]
    known = evidence(rows)
    (question,) = ambiguities(known, seen([2.0, 0.0]))
    assert (question.learned.next_state, question.other.next_state) == ("Go", "Pass")
    for answer in ("Go", "Pass"):
        answered = known.with_answer(question.situation, answer)
        near, lost = [1.0, 0.0], [2.4, 0.0]
        assert decisions(answered, [near, lost]) == [answer, answer]
        assert np.array_equal(decisions(answered, known.values), known.next_states)


@given(
    st.lists(
        st.tuples(
            st.tuples(st.integers(0, 4), st.integers(0, 3), st.integers(0, 1)),
            st.sampled_from("ST"),
            st.booleans(),
        ),
        min_size=2,
        max_size=8,
    ),
    st.lists(st.tuples(st.integers(0, 4), st.integers(0, 3), st.integers(0, 1)), max_size=8),
    st.booleans(),
)
def test_alternatives_explain_as_well_and_differ_where_is_asked(drawn, readings, boolean_first):
    scales = (METERS, Scale(FeatureKind.TOROIDAL, 4.0), BOOLEAN_SCALE)
    rows = [("S", tuple(map(float, v)), goes, is_default) for v, goes, is_default in drawn]
    text = f"tree(boolean_first={boolean_first})"
    known = evidence(rows, scales, ("a", "b", "c"), ("",) * 3, text)
    learned, others = alternatives(known)
    for tree in others:
        assert misfits(tree, known) <= misfits(learned, known)
        assert leaves(tree) <= leaves(learned)
    values = np.array(readings, float).reshape(-1, 3)
    for question in ambiguities(known, seen(*values.tolist())):
        assert question.situation in {*map(tuple, values.tolist())}
        assert question.learned.next_state != question.other.next_state
        assert str(learned.predict([question.situation])[0]) == question.learned.next_state


def misfits(tree, known):
    """Return the number of examples that are not the most probable of their leaf."""
    odds = tree.predict_proba(known.values)
    own = [tree.labels.index(label) for label in known.next_states]
    return sum(row[label] < row.max() for row, label in zip(odds, own, strict=True))


def leaves(tree):
    """Return the number of a tree's leaves."""
    return sum(isinstance(node, Leaf) for node in nodes(tree.root_))
