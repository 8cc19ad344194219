"""From examples to one transition function per state."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hitab_core.automaton import START, Automaton
from hitab_core.domain import FeatureKind, Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.learning.transition_learning import learn_transitions, learner
from hitab_core.learning.transition_tree import TransitionTree
from hitab_core.term import Term
from hitab_core.texts.errors import FeatureValueError, TrainingError, VocabularyError

METERS = Scale()
DEFAULT = ExampleKind.DEFAULT

EXAMPLES = [
    Example(START, (9.0, 0.0), "GoFast", number=1),
    Example("GoFast", (9.0, 0.0), "GoFast", DEFAULT, number=2),
    Example("GoFast", (4.0, 0.0), "GoSlow", number=3),
    Example("GoSlow", (4.0, 0.0), "GoSlow", DEFAULT, number=4),
    Example("GoSlow", (1.0, 1.0), "Stop", number=5),
    Example("Stop", (1.0, 1.0), "Stop", DEFAULT, number=6),
]
SCALES = [METERS, Scale(FeatureKind.BOOLEAN)]


def learn_transition(classifier, scales, X, y, default=None, names=None):
    """Learn the transition function of one state; by default no example is a default one."""
    return learner(classifier, scales, names)(X, y, default or [False] * len(y))


def decisions(function, rows):
    """Return the most probable next state of each row."""
    return [max((e := function.explain(r, "ab").distribution), key=e.get) for r in rows]


def test_each_state_with_examples_has_a_function_in_order_of_appearance():
    functions = learn_transitions(EXAMPLES, SCALES)
    assert list(functions) == [START, "GoFast", "GoSlow", "Stop"]
    Automaton(
        "ApproachBall",
        tuple(map(Term, ("GoFast", "GoSlow", "Stop"))),
        (Term("DistanceTo", ("ball",)), Term("BallIsKickable")),
        functions,
    )


label = st.sampled_from(["GoFast", "GoSlow", "Stop"])
taught = st.lists(
    st.builds(
        Example,
        st.sampled_from([START, "GoFast", "Stop"]),
        st.tuples(st.integers(0, 5).map(float), st.sampled_from([0.0, 1.0])),
        label,
        st.sampled_from([ExampleKind.DEMONSTRATED, DEFAULT]),
    ),
    max_size=20,
)


@given(taught)
def test_a_function_is_learned_from_the_examples_of_its_state_alone(examples):
    together = learn_transitions(examples, SCALES)
    assert set(together) == {e.state for e in examples}
    for state, function in together.items():
        alone = learn_transitions([e for e in examples if e.state == state], SCALES)
        assert alone[state].digest() == function.digest()


def test_default_examples_leave_the_rest_of_the_world_to_keeping_on():
    functions = learn_transitions(EXAMPLES[:4], SCALES)
    assert functions["GoFast"].root_.test.threshold == math.nextafter(4, 9)
    assert decisions(functions["GoFast"], [(4.0, 0.0), (4.0001, 0.0), (100.0, 0.0)]) == [
        "GoSlow",
        "GoFast",
        "GoFast",
    ]


def test_the_trees_parameters_can_be_given_in_words():
    pruned = learn_transition(
        "tree(prune=True, min_samples_leaf=2)",
        [METERS],
        [[1], [2], [3], [4]],
        ["A", "A", "B", "B"],
    )
    assert isinstance(pruned, TransitionTree)
    assert (pruned.prune, pruned.min_samples_leaf) == (True, 2)


def test_a_classifier_that_does_not_exist_is_refused_with_what_there_is():
    for spec, error, why in [
        (
            "tree(depth=3)",
            VocabularyError,
            r'no parameter "depth" \(known: all_around, boolean_first',
        ),
        ("tree(scales=None)", VocabularyError, 'no parameter "scales"'),
        ("forest", VocabularyError, '"forest" is not a classifier'),
        ("tree(max_depth=-1)", TrainingError, 'state "Start": "tree.*" cannot learn'),
        ("tree(max_depth='deep')", TrainingError, "cannot learn"),
    ]:
        with pytest.raises(error, match=why):
            learn_transitions(EXAMPLES, SCALES, spec)


@pytest.mark.parametrize(
    ("classifier", "value"), [("tree", math.inf), ("sklearn.naive_bayes.GaussianNB", math.nan)]
)
def test_a_value_that_is_not_taken_is_refused_by_feature_example_and_state(classifier, value):
    broken = [*EXAMPLES, Example("GoFast", (value, 0.0), "Stop", number=7)]
    with pytest.raises(
        FeatureValueError,
        match=rf'feature 0 "DistanceTo\(ball\)" has value {value} in example 7 of state "GoFast"',
    ):
        learn_transitions(broken, SCALES, classifier, ["DistanceTo(ball)", "BallIsKickable"])


def test_a_circle_without_a_length_is_refused():
    with pytest.raises(VocabularyError, match="period"):
        learn_transitions(
            [Example(START, (1.0,), "Stop")], [Scale(FeatureKind.TOROIDAL)], names=["a"]
        )
