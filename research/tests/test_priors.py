"""What the learner takes for granted, measured."""

from random import Random

import circle
import constants
import pytest
import trees
from sklearn.datasets import load_iris


def test_on_the_same_folds_a_tree_with_plain_gain_is_as_good_as_scikit_learns():
    names = [trees.REFERENCE, "ours", "gain, random ties"]
    X, y = load_iris(return_X_y=True)
    found = trees.accuracies(X, y, names, repeats=1, seed=11, say=lambda text: None)
    assert {len(accuracies) for accuracies in found.values()} == {trees.FOLDS}
    for name in names:
        mean, naive, corrected = trees.difference(found[name], found[trees.REFERENCE])
        assert naive <= corrected
        assert abs(mean) <= 0.05


@pytest.mark.parametrize(("task", "least"), [("turning", 0.9), ("docking", 0.85)])
def test_with_one_question_both_ends_of_an_arc_are_learned(task, least):
    arc = circle.TASKS[task]
    before, after = circle.taught(arc, 1, Random(5), "tree")
    assert min(after) >= least
    assert after >= before


def test_an_answer_at_the_back_does_not_take_back_what_was_learned_of_a_side():
    random = Random(6)
    learned = [circle.taught(circle.anything(random), 3, random, "tree") for _ in range(20)]
    first, *_, last = zip(*learned, strict=True)
    assert sum(right for right, _ in last) > sum(right for right, _ in first)


def test_every_constant_has_another_value_at_half_and_double_and_is_put_back():
    for constant in constants.CONSTANTS:
        usual = constant.value
        for factor in (0.5, 2.0):
            with constants.patched(constant, constants.varied(usual, factor)):
                assert constant.value is not usual
            assert constant.value is usual


def test_some_shipped_trees_change_if_a_tie_is_a_whole_bit():
    (tie,) = (c for c in constants.CONSTANTS if c.name == "TIE")
    before = constants.shipped()
    with constants.patched(tie, 1.0):
        after = constants.shipped()
    assert constants.changed(before, before) == 0 < constants.changed(before, after)
