"""Who is waited for in a cycle of the world."""

import pytest

from hitab_world.simulating.lockstep import RoundAnswers

ANSWER = ([1.0], "")


class Nodes:
    """The agents for which a node has joined."""

    def __init__(self, *names):
        self.names = set(names)

    def __call__(self, name):
        return name in self.names


@pytest.fixture
def nodes():
    return Nodes("ann", "bob")


@pytest.fixture
def round_answers(nodes):
    made = RoundAnswers(("ann", "bob", "cy"), nodes)
    made.look()
    return made


def test_who_is_late_is_counted_and_not_waited_for_again(round_answers):
    round_answers.begin(1)
    round_answers.take("ann", 1, ANSWER)
    assert round_answers.count_late(exclude=True) == ["bob"]
    assert round_answers.missed_deadlines == 1
    round_answers.begin(2)
    round_answers.take("ann", 2, ANSWER)
    assert round_answers.complete
    assert round_answers.missing == ["bob", "cy"]


def test_a_late_answer_brings_its_agent_back(round_answers):
    round_answers.begin(1)
    round_answers.take("ann", 1, ANSWER)
    round_answers.give_up_on_late()
    assert round_answers.silent
    round_answers.begin(2)
    round_answers.take("ann", 2, ANSWER)
    assert round_answers.complete
    round_answers.take("bob", 1, ANSWER)
    round_answers.begin(3)
    round_answers.take("ann", 3, ANSWER)
    assert not round_answers.complete
    round_answers.take("bob", 3, ANSWER)
    assert round_answers.complete
    assert round_answers.missing == ["cy"]


def test_when_all_are_late_they_waited_for_somebody_else_and_are_waited_for_again(round_answers):
    round_answers.begin(1)
    assert round_answers.count_late(exclude=True) == ["ann", "bob"]
    round_answers.begin(2)
    assert not round_answers.complete
    assert round_answers.missing == ["cy"]


def test_who_leaves_and_comes_back_begins_anew(round_answers, nodes):
    round_answers.begin(1)
    round_answers.take("ann", 1, ANSWER)
    round_answers.give_up_on_late()
    nodes.names = {"ann"}
    assert round_answers.look()
    nodes.names = {"ann", "bob"}
    assert round_answers.look()
    assert not round_answers.look()
    round_answers.begin(2)
    round_answers.take("ann", 2, ANSWER)
    assert not round_answers.complete, "bob is waited for again"


def test_who_was_given_up_on_in_a_pause_is_waited_for_when_play_begins(round_answers):
    round_answers.begin(1, look=True)
    round_answers.take("ann", 1, ANSWER)
    round_answers.give_up_on_late()
    round_answers.begin(2, look=True)
    round_answers.take("ann", 2, ANSWER)
    assert round_answers.complete, "a pause is not slowed down again and again"
    round_answers.begin(3)
    round_answers.take("ann", 3, ANSWER)
    assert round_answers.count_late(exclude=True) == ["bob"]
    assert round_answers.missed_deadlines == 1
    round_answers.begin(4)
    round_answers.take("ann", 4, ANSWER)
    assert round_answers.complete
