"""How sure a decision is: how far it is from what was demonstrated."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_core.advice.confidence import Confidences, RatedFunctions
from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import UNKNOWN_DISTANCE, Nearness
from hitab_core.automaton import Automaton
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.learning.transition_learning import learn_transitions, learner
from hitab_core.term import Term
from hitab_core.transition_function import HandWritten

METERS = Scale()
DEGREES = Scale(FeatureKind.TOROIDAL, 360.0)


def learn_transition(classifier, scales, X, y, default=None, names=None):
    """Learn the transition function of one state; by default no example is a default one."""
    return learner(classifier, scales, names)(X, y, default or [False] * len(y))


def evidence(rows, scales, classifier="tree"):
    """Return the evidence of rows (values, next state, is default) of state S."""
    kinds = (ExampleKind.DEMONSTRATED, ExampleKind.DEFAULT)
    examples = [Example("S", values, goes_to, kinds[default]) for values, goes_to, default in rows]
    names = [f"f{i}" for i in range(len(scales))]
    return Evidence.of("S", examples, scales, names, (), classifier)


def rated(rows, scales, classifier="tree"):
    """Return what rates decisions of what is learned from rows."""
    known = evidence(rows, scales, classifier)
    function = learn_transition(
        classifier, scales, known.values, known.next_states, known.default.tolist()
    )
    return Confidences(function, known)


BALL = [
    ((9.0, 0.0), "Go", True),
    ((8.0, 0.0), "Go", True),
    ((7.0, 0.0), "Go", False),
    ((1.0, 1.0), "Stop", False),
]


def test_distance_on_a_line_is_in_median_differences_of_the_examples():
    rate = rated([((0.0,), "A", False), ((2.0,), "B", False), ((4.0,), "B", False)], [METERS])
    assert rate.distance([5.0]) == pytest.approx(1 / 2)  # the differences are 2, 2 and 4
    assert rate.distance([-3.0]) == pytest.approx(3 / 2)
    assert rate.distance([1.2]) == pytest.approx(0.8 / 2)


def test_values_that_are_missing_are_left_out():
    values = np.array([[0.0, math.nan], [4.0, 10.0], [math.nan, math.nan]])
    near = Nearness(values, [METERS, METERS], (0, 1))
    assert near([0.0, 10.0]) == 0  # the first example does not say
    assert near([4.0, None]) == near([4.0, math.nan]) == 0
    assert near([math.nan, math.nan]) == UNKNOWN_DISTANCE
    assert Nearness(values, [METERS, METERS], ())([1.0, 2.0]) == 0


def test_a_decision_without_a_tested_value_is_as_far_away_as_its_farthest_leaf():
    rate = rated(BALL, [METERS, Scale(FeatureKind.BOOLEAN)])
    assert rate.distance([8.5, 0.0]) == rate.distance([8.5, 1.0]) == 0
    assert rate.distance([8.5, None]) == rate.distance([8.5, math.nan]) == UNKNOWN_DISTANCE


def test_of_what_is_no_tree_the_distance_is_known_too():
    known = evidence([((0.0, 0.0), "A", False), ((2.0, 0.0), "B", False)], [METERS, METERS])
    rate = Confidences(HandWritten(lambda first: "A", (0,)), known)
    assert rate.distance([3.0, None]) == pytest.approx(0.5)
    assert rate.doubts([3.0, None], 0.6) == ""
    why = "it is 0.5 spreads of the examples from the nearest one"
    assert rate.doubts([3.0, None], 0.4) == why


def test_an_automaton_is_rated_by_state_without_its_superseded_examples():
    features = (1.0,)
    examples = (
        Example("Start", features, "Go"),
        Example("Go", features, "Go", ExampleKind.SUPERSEDED),
        Example("Go", (7.0,), "Stop", ExampleKind.CORRECTION),
    )
    shuttle = Automaton(
        "Shuttle",
        (Term("Go"), Term("Stop")),
        (Term("Range"),),
        {**learn_transitions(examples, [METERS]), "Stop": HandWritten(lambda: "Go")},
        examples=examples,
    )
    evidence = {
        state: Evidence.of(state, shuttle.examples, [METERS], ["Range"])
        for state in shuttle.transitions
    }
    assert [state for state, of in evidence.items() if of.next_states] == ["Start", "Go"]
    rated = Confidences(shuttle.transitions["Go"], evidence["Go"])
    assert rated.distance([1.0]) == 0.0, "one example alone has no threshold"
    assert evidence["Go"].values.tolist() == [[7.0]]


@given(
    st.lists(
        st.tuples(
            st.floats(-50, 50), st.floats(0, 359), st.integers(0, 1), st.sampled_from("ABC")
        ),
        min_size=1,
        max_size=12,
    ),
    st.tuples(st.floats(-60, 60), st.floats(-400, 400), st.integers(0, 1)),
)
def test_the_distance_is_that_of_the_nearest_example_in_the_tested_features(rows, situation):
    scales = [METERS, DEGREES, Scale(FeatureKind.BOOLEAN)]
    known = evidence([(row[:3], row[3], False) for row in rows], scales)
    tree = known.learn()
    rate = Confidences(tree, known)
    tested = tree.retrace(situation, ("a", "b", "c")).features
    found = rate.distance([v if f in tested else None for f, v in enumerate(situation)])
    assert found == pytest.approx(Nearness(known.values, scales, sorted(tested))(situation))
    for row in known.values.tolist():
        assert rate.distance(row) == pytest.approx(0, abs=1e-9)


def test_a_decision_that_was_made_is_rated_by_what_it_read():
    rate = rated(BALL, [METERS, Scale(FeatureKind.BOOLEAN)])
    whole = [8.5, 0.0]
    read = [
        f
        for f in range(2)
        if math.isnan(rate.decided([None if g == f else whole[g] for g in range(2)]))
    ]
    assert len(read) == 1  # the tree tests one of the two
    assert rate.decided(whole) == rate.distance(whole) == 0
    missing = [math.nan if f in read else whole[f] for f in range(2)]
    assert rate.decided(missing) == rate.distance(missing) == UNKNOWN_DISTANCE


def test_functions_are_rated_once_and_anew_when_learned_again():
    domain = SimpleNamespace(scale_of=lambda term: METERS)
    examples = [Example("S", (v,), "A", ExampleKind.DEMONSTRATED) for v in (0.0, 2.0)]
    known = evidence([((0.0,), "A", False), ((2.0,), "B", False)], [METERS])
    one, other = (
        learn_transition("tree", [METERS], known.values, known.next_states) for _ in range(2)
    )
    rates = RatedFunctions()
    first = rates.of(one, "S", [Term("X")], examples, domain)
    assert rates.of(one, "S", [Term("X")], examples, domain) is first
    assert rates.of(other, "S", [Term("X")], examples, domain) is not first
