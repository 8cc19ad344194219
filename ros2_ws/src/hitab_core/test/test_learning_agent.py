"""Training from a notebook: ten lines, and errors that show the way out."""

from datetime import datetime
from random import Random

import numpy as np
import pytest

from hitab_core import (
    FeatureValueError,
    LearningAgent,
    LibraryError,
    LostBehaviorError,
    Term,
    TrainingError,
    VocabularyError,
    plain_domain,
)


def cart():
    return plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])


def shuttle(agent):
    agent.train("Shuttle")
    agent.step([0.0], command="Right")
    agent.step([5.0], command="Left")
    agent.step([0.0], command="Right")
    return agent


def test_ten_lines_train_an_agent_that_goes_on_by_itself():
    agent = shuttle(LearningAgent(cart()))
    agent.learn()

    position, seen = 1.0, []
    for _ in range(20):
        (speed,) = agent.step([position])
        position += speed
        seen.append(position)

    assert max(seen) == 5.0
    assert min(seen) == 0.0
    assert seen.index(5.0) < seen.index(0.0)


def test_an_unsaved_training_is_not_thrown_away_and_the_error_says_what_to_call():
    agent = shuttle(LearningAgent(cart()))
    with pytest.raises(TrainingError, match=r'"Shuttle" has 6 unsaved .* call save\(\)'):
        agent.train("Other")
    agent.train("Other", discard=True)
    assert agent.agent.training == "Other"


def test_a_command_after_learning_is_a_correction():
    agent = shuttle(LearningAgent(cart()))
    agent.learn()
    agent.decide([1.0])
    agent.step([3.0], command="Left")
    agent.learn()
    agent.decide([1.0])

    assert agent.examples[-2].kind == "correction"
    assert agent.decide([3.0]) == "Left"


def test_saving_warns_of_what_does_not_play_with_what_would_mend_it():
    agent = LearningAgent(cart()).train("Stuck")
    for command in ("Right", "Left", "Right"):
        agent.step([3.0], command=command)
    with pytest.warns(UserWarning, match=r"it changes between .* forever; have example . of"):
        agent.save()


def test_commands_that_do_not_depend_on_the_features_are_remarked_on():
    agent = LearningAgent(plain_domain("dice", ["Left", "Right"], ["X"])).train("Guess")
    random = Random(1)
    for _ in range(100):
        agent.step([random.random()], command=random.choice(["Left", "Right"]))
    with pytest.warns(UserWarning, match=r"rules for \d+ examples: .* hardly depends on X"):
        agent.learn()


def test_a_damaged_library_is_a_warning_and_what_is_lost_is_refused_with_the_reason(tmp_path):
    file = shuttle(LearningAgent(cart(), tmp_path / "library")).save()
    file.write_text("nothing")
    with pytest.warns(
        UserWarning, match=r"Shuttle is lost: .* cannot be used: .*; bring version 1 of"
    ):
        agent = LearningAgent(cart(), tmp_path / "library")
    with pytest.raises(LostBehaviorError, match="Shuttle is lost"):
        agent.perform("Shuttle")


def test_functions_of_the_percept_are_features_and_behaviors():
    domain = plain_domain(
        "rover",
        {"Ahead": lambda percept: [percept[0] / 2.0], "Halt": []},
        {"Sum": lambda percept: sum(percept)},
    )
    agent = LearningAgent(domain).train("Go")
    assert agent.step([4.0, 1.0], command="Ahead") == (2.0,)
    assert agent.examples[0].features == (5.0,)


def test_what_is_used_wrongly_is_refused_with_the_way_out():
    for wrong, error, words in [
        (lambda a: a.step([1.0], command="Lft"), VocabularyError, 'Did you mean "Left"?)'),
        (lambda a: a.step([1.0, 2.0]), FeatureValueError, "has 2 values, the first one had 1"),
        (lambda a: a.learn(), TrainingError, "command the behavior"),
        (lambda a: a.step([1.0]), TrainingError, 'step(percept, command="Left")'),
        (lambda a: a.decide([1.0]), TrainingError, "call learn() after commanding"),
        (lambda a: a.train("Other", ["Positon"]), VocabularyError, "Position"),
        (lambda a: a.perform("Shutle"), VocabularyError, "(known: Left, Right)"),
        (lambda a: a.save(), TrainingError, "command the behavior"),
    ]:
        agent = LearningAgent(cart()).train("Shuttle")
        with pytest.raises(TrainingError):
            agent.step([1.0])  # nothing was commanded yet
        with pytest.raises(error) as raised:
            wrong(agent)
        assert words in str(raised.value)


def test_a_command_can_be_due_some_steps_ago():
    agent = LearningAgent(plain_domain("cart", ["Left", "Right"], ["X"]), period=0.5).train("It")
    agent.step([0.0], "Right")
    for x in (1.0, 2.0, 3.0):
        agent.step([x])
    agent.step([4.0], "Left", ago=1.0)
    assert [(e.features, e.state) for e in agent.examples[::2]] == [
        ((0.0,), "Start"),
        ((2.0,), "Right"),
    ]


def test_a_first_percept_that_is_refused_does_not_stand_in_the_way_of_those_after_it():
    for wrong in [{"x": 1.0, "y": 2.0}, "1.0", ["a", "b"], [[1.0, 2.0]], 3.0, None, [], [1.0]]:
        domain = plain_domain("pair", ["Go", "Wait"], {"Sum": lambda p: p[0] + p[1]})
        agent = LearningAgent(domain).train("It")
        with pytest.raises(FeatureValueError):
            agent.step(wrong, command="Go")
        assert agent.examples == ()
        agent.step([1.0, 2.0], command="Go")
        agent.step([5.0, 2.0], command="Wait")
        agent.learn()
        assert [agent.decide([x, 2.0]) for x in (1.0, 5.0)] == ["Go", "Wait"]


class NAType:
    """As pandas' NA: a value that cannot be compared or become a number."""

    def __bool__(self):
        raise TypeError("boolean value of NA is ambiguous")

    __float__ = __bool__

    def __eq__(self, other):
        return self

    __ne__, __hash__ = __eq__, None


@pytest.mark.parametrize("missing", [None, float("nan"), np.float64("nan"), NAType()])
def test_cells_without_a_value_are_no_command_and_no_value(missing):
    agent = LearningAgent(plain_domain("pair", ["Go", "Wait"], ["X", "Y"])).train("It")
    agent.step([1.0, missing], command=np.str_("Go"))
    agent.step([2.0, 1.0], command=missing)
    agent.step(np.array([5.0, 1.0]), command="Wait")
    agent.step([6.0, 1.0], command="")
    assert [example.next_state for example in agent.examples[::2]] == ["Go", "Wait"]
    assert np.isnan(agent.examples[0].features[1])


def test_what_is_neither_a_number_nor_missing_is_refused_by_its_place():
    agent = LearningAgent(plain_domain("pair", ["Go", "Wait"], ["X", "Y"])).train("It")
    for value in (datetime(2026, 1, 1), object(), 1j):
        with pytest.raises(FeatureValueError, match=r"value 2 of the percept is .* no number"):
            agent.step([1.0, value], command="Go")
    for command in (1, np.int64(1), 2.5, b"Go"):
        with pytest.raises(TrainingError, match=r"the command is .*; give the name of a"):
            agent.step([1.0, 2.0], command=command)
    assert agent.examples == ()


def test_the_head_of_a_file_of_excel_is_distinguished_from_a_name():
    with pytest.raises(VocabularyError, match=r'encoding="utf-8-sig"\), delimiter=";"'):
        plain_domain("robot", ["Go"], ["\ufeffcommand;Range;Battery"])


def test_an_example_that_no_file_may_hold_is_named_with_the_way_out(tmp_path):
    agent = shuttle(LearningAgent(cart(), tmp_path))
    agent.agent.sense([3.0], (), 2**60, 9.0)
    agent.agent.command(Term("Left"))
    bad = agent.examples[-2].number
    with pytest.raises(LibraryError, match=rf"example {bad} is of cycle 1152921504606846976"):
        agent.save()
    assert not list(tmp_path.glob("*.yaml"))
    agent.agent.session.delete([bad, bad + 1])
    assert agent.save().is_file()


def test_a_domain_that_cannot_be_is_refused():
    for behaviors, features, words in [
        ({"Go": "fast"}, ["X"], "list of numbers"),
        ({"Go": []}, {"X": 3.0}, "give a function of the percept"),
        ({"Go on": []}, ["X"], "is not a name"),
        (["Go", "Stop"], ["X", "X"], '"X" twice'),
    ]:
        with pytest.raises(VocabularyError, match=words):
            plain_domain("bad", behaviors, features)
