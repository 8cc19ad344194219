"""Who is waited for in a cycle of the world."""

import pytest

from hitab_world.attendance import Attendance

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
def attendance(nodes):
    made = Attendance(("ann", "bob", "cy"), nodes)
    made.look()
    return made


def test_only_those_who_are_there_are_waited_for(attendance):
    attendance.begin(1)
    attendance.take("ann", 1, ANSWER)
    assert not attendance.complete
    attendance.take("bob", 1, ANSWER)
    assert attendance.complete
    assert attendance.missing == ["cy"]
    assert set(attendance.answers) == {"ann", "bob"}


def test_an_answer_to_an_earlier_round_does_not_count(attendance):
    attendance.begin(1)
    attendance.begin(2)
    attendance.take("ann", 1, ANSWER)
    assert not attendance.answers
    assert not attendance.complete


def test_who_is_late_is_counted_and_not_waited_for_again(attendance):
    attendance.begin(1)
    attendance.take("ann", 1, ANSWER)
    assert attendance.count_late(exclude=True) == ["bob"]
    assert attendance.missed_deadlines == 1
    attendance.begin(2)
    attendance.take("ann", 2, ANSWER)
    assert attendance.complete
    assert attendance.missing == ["bob", "cy"]


def test_in_real_time_who_is_late_is_counted_and_still_waited_for(attendance):
    attendance.begin(1)
    assert attendance.count_late(exclude=False) == ["ann", "bob"]
    attendance.begin(2)
    assert not attendance.complete
    assert not attendance.silent


def test_a_late_answer_brings_its_agent_back(attendance):
    attendance.begin(1)
    attendance.take("ann", 1, ANSWER)
    attendance.give_up_on_late()
    assert attendance.silent
    attendance.begin(2)
    attendance.take("ann", 2, ANSWER)
    assert attendance.complete
    attendance.take("bob", 1, ANSWER)
    attendance.begin(3)
    attendance.take("ann", 3, ANSWER)
    assert not attendance.complete
    attendance.take("bob", 3, ANSWER)
    assert attendance.complete
    assert attendance.missing == ["cy"]


def test_when_all_are_late_they_waited_for_somebody_else_and_are_waited_for_again(attendance):
    attendance.begin(1)
    assert attendance.count_late(exclude=True) == ["ann", "bob"]
    attendance.begin(2)
    assert not attendance.complete
    assert attendance.missing == ["cy"]


def test_giving_up_on_somebody_in_a_pause_is_not_a_missed_deadline(attendance):
    attendance.begin(1)
    attendance.give_up_on_late()
    assert attendance.missed_deadlines == 0


def test_who_leaves_and_comes_back_begins_anew(attendance, nodes):
    attendance.begin(1)
    attendance.take("ann", 1, ANSWER)
    attendance.give_up_on_late()
    nodes.names = {"ann"}
    assert attendance.look()
    nodes.names = {"ann", "bob"}
    assert attendance.look()
    assert not attendance.look()
    attendance.begin(2)
    attendance.take("ann", 2, ANSWER)
    assert not attendance.complete, "bob is waited for again"


def test_who_was_given_up_on_in_a_pause_is_waited_for_when_play_begins(attendance):
    attendance.begin(1, look=True)
    attendance.take("ann", 1, ANSWER)
    attendance.give_up_on_late()
    attendance.begin(2, look=True)
    attendance.take("ann", 2, ANSWER)
    assert attendance.complete, "a pause is not slowed down again and again"
    attendance.begin(3)
    attendance.take("ann", 3, ANSWER)
    assert attendance.count_late(exclude=True) == ["bob"]
    assert attendance.missed_deadlines == 1
    attendance.begin(4)
    attendance.take("ann", 4, ANSWER)
    assert attendance.complete
