"""A scikit-learn classifier in the place of the tree, for comparison."""

import math

import numpy as np
import pytest

from hitab_core.domain import FeatureKind, Scale
from hitab_core.learning.classifier_spec import ClassifierSpec
from hitab_core.learning.feature_encoding import encoding_of
from hitab_core.learning.transition_learning import learner
from hitab_core.texts.errors import FeatureValueError, TrainingError, VocabularyError

METERS = Scale()
DEGREES = Scale(FeatureKind.TOROIDAL, 360.0)
BOOLEAN = Scale(FeatureKind.BOOLEAN)
NEAREST = "sklearn.neighbors.KNeighborsClassifier(n_neighbors=1)"
STATES = {"Start": 0, "Stop": 1, "GoFast": 2}
TWO = ([[1.0], [2.0]], ["Stop", "GoFast"])


def learn_transition(classifier, scales, X, y, default=None, names=None):
    """Learn the transition function of one state; by default no example is a default one."""
    return learner(classifier, scales, names)(X, y, default or [False] * len(y))


def no_reading(slot):
    """Fail: all values are there."""
    raise AssertionError(f"slot {slot} was read again")


# The text


def test_a_classifier_is_named_with_keywords_that_are_literals():
    for text, name, arguments in [
        ("tree", "tree", {}),
        (" tree(prune=True, confidence=0.1) ", "tree", {"prune": True, "confidence": 0.1}),
        (NEAREST, "sklearn.neighbors.KNeighborsClassifier", {"n_neighbors": 1}),
        ("a.B(c=[1, -2], d={'x': None})", "a.B", {"c": [1, -2], "d": {"x": None}}),
    ]:
        spec = ClassifierSpec.parse(text)
        assert (spec.name, spec.arguments) == (name, arguments)
        assert ClassifierSpec.parse(str(spec)) == spec


def test_any_other_text_is_refused_and_never_run(capsys):
    for text in [
        "",
        "tree(",
        "tree(3)",
        "tree(*[3])",
        "tree(**{'prune': True})",
        "tree()()",
        "tree; import os",
        "tree(prune=print('run'))",
        "__import__('os').system('true')",
        "sklearn.svm.SVC(C=(lambda: 1)())",
        "(tree)[0]",
        "tree(confidence=x)",
        "tree\0",
        "tree(" + "(" * 3000,
    ]:
        with pytest.raises(VocabularyError, match='write "tree" or'):
            ClassifierSpec.parse(text)
        assert capsys.readouterr().out == ""


def test_only_what_scikit_learn_lists_as_a_classifier_is_made():
    for name in [
        "sklearn.neighbors.KNeighborsRegressor",
        "sklearn.utils.all_estimators",
        "sklearn.neighbors._classification.KNeighborsClassifier",
        "KNeighborsClassifier",
        "sklearn.nowhere.KNeighborsClassifier",
        "os.system",
        "subprocess.Popen",
        "hitab_core.learning.transition_tree.TransitionTree",
    ]:
        with pytest.raises(
            VocabularyError,
            match=rf'"{name}" is not a classifier.*; write "tree", or .*Classifier',
        ):
            learn_transition(name, [METERS], *TWO)


# How it sees features


def test_a_toroidal_feature_has_no_zero_for_it():
    function = learn_transition(NEAREST, [DEGREES], [[350], [180]], ["GoFast", "Stop"])
    decide = function.compile([0], STATES)
    assert [decide([float(a)], no_reading, None) for a in (5, 365, -80, 100, 260)] == [
        2,
        2,
        2,
        1,
        1,
    ]


def test_categories_that_the_scale_does_not_name_are_those_seen():
    unnamed = Scale(FeatureKind.CATEGORICAL)
    encoding = encoding_of(np.array([[0.0], [1.0]]), [unnamed])
    assert encoding(np.array([[1.0], [7.0]])).tolist() == [[0, 1], [0, 0]]


# Decisions


def test_it_reads_all_features_from_their_slots_each_once():
    X, y = [[1.0, 0.0], [2.0, 1.0]], ["Stop", "GoFast"]
    function = learn_transition(NEAREST, [METERS, BOOLEAN], X, y)
    assert function.features_used == (0, 1)
    values, read = [None, 1.0, None], []

    def reading(slot):
        read.append(slot)
        return 2.0

    assert function.compile([2, 1], STATES)(values, reading, None) == 2
    assert read == [2]


def test_classifiers_with_and_without_probabilities_decide_what_they_predict():
    for spec in [
        "sklearn.linear_model.RidgeClassifier",
        "sklearn.linear_model.Perceptron()",
        "sklearn.svm.SVC(kernel='linear')",
        "sklearn.naive_bayes.GaussianNB",
        "sklearn.ensemble.RandomForestClassifier(n_estimators=5)",
        "sklearn.tree.DecisionTreeClassifier",
    ]:
        X = [[x, (x * 40) % 360] for x in range(10)]
        y = ["Stop" if x < 5 else "GoFast" for x in range(10)]
        function = learn_transition(spec, [METERS, DEGREES], X, y)
        decide = function.compile([0, 1], STATES)
        assert [decide([0.0, 0.0], no_reading, None), decide([9.0, 0.0], no_reading, None)] == [
            1,
            2,
        ]
        explained = function.explain([0.0, 0.0], ["d", "a"])
        assert explained.tests == (spec.removesuffix("()"),)
        assert explained.distribution == {"Stop": 1.0}
        again = learn_transition(spec, [METERS, DEGREES], X, y)
        asked = [[x / 2, (x * 40) % 360] for x in range(20)]
        for values in asked:
            assert again.explain(values, ["d", "a"]) == function.explain(values, ["d", "a"])
        assert again.digest() == function.digest()


def test_what_is_learned_from_has_a_digest():
    digests = {
        learn_transition(spec, scales, X, y).digest()
        for spec, scales, X, y in (
            (NEAREST, [METERS], [[1], [2]], ["A", "B"]),
            (NEAREST, [METERS], [[1], [3]], ["A", "B"]),
            (NEAREST, [METERS], [[1], [2]], ["A", "C"]),
            (NEAREST, [DEGREES], [[1], [2]], ["A", "B"]),
            ("sklearn.naive_bayes.GaussianNB", [METERS], [[1], [2]], ["A", "B"]),
        )
    }
    assert len(digests) == 5


def test_examples_that_the_classifier_cannot_learn_from_are_the_demonstrators_to_mend():
    too_few = "sklearn.neighbors.KNeighborsClassifier(n_neighbors=5)"
    for spec in (too_few, "sklearn.svm.SVC(C='many')"):
        with pytest.raises(TrainingError, match=r"cannot learn from 2 examples: .*use the tree"):
            learn_transition(spec, [METERS], *TWO)


def test_missing_values_are_refused_by_name():
    with pytest.raises(FeatureValueError, match='feature 0 "DistanceTo"'):
        learn_transition(NEAREST, [METERS], [[math.nan], [2]], ["A", "B"], names=["DistanceTo"])
    function = learn_transition(NEAREST, [METERS], *TWO)
    with pytest.raises(FeatureValueError, match="feature 0"):
        function.compile([0], STATES)([math.nan], no_reading, None)


def test_where_all_examples_say_the_same_there_is_nothing_to_learn():
    function = learn_transition("sklearn.svm.SVC", [METERS], [[1.0], [2.0]], ["Stop", "Stop"])
    assert function.features_used == ()
    assert function.compile([0], STATES)([None], no_reading, None) == STATES["Stop"]
