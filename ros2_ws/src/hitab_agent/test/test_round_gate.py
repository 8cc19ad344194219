"""Whose orders are waited for in a lockstep round."""

import pytest

from hitab_agent import RoundGate
from hitab_core.orders import Order

CAPTAIN = "/captain/order"


class Orders:
    """The orders of commanders, given by hand."""

    def follow(self, topic, hear):
        self.hear = hear

    def give(self, round_number, epoch=1):
        self.hear(CAPTAIN, Order(round=round_number, epoch=epoch))


class Rounds:
    """A gate, and the rounds in which it let the agent act."""

    def __init__(self):
        self.orders, self.acted = Orders(), []
        self.gate = RoundGate(self.orders)

    def begin(self, number, *, look=False):
        self.gate.begin(number, [CAPTAIN], lambda: self.acted.append(number), look=look)


@pytest.fixture
def rounds():
    return Rounds()


def test_the_agent_acts_once_its_commander_has_given_its_order(rounds):
    rounds.begin(1)
    assert not rounds.acted
    rounds.orders.give(1)
    assert rounds.acted == [1]


def test_an_order_of_an_earlier_round_is_not_enough(rounds):
    rounds.begin(1)
    rounds.orders.give(1)
    rounds.begin(2)
    rounds.orders.give(1)
    assert rounds.acted == [1]
    rounds.orders.give(2)
    assert rounds.acted == [1, 2]


def test_a_commander_that_missed_a_round_is_waited_for_again_once_it_has_spoken(rounds):
    rounds.begin(1)
    rounds.begin(2)
    assert rounds.acted == [2]
    rounds.orders.give(2)
    rounds.begin(3)
    assert rounds.acted == [2]


def test_a_commander_that_was_silent_in_a_pause_costs_a_deadline_when_play_begins(rounds):
    rounds.begin(1, look=True)
    rounds.begin(2, look=True)
    assert rounds.acted == [2]
    rounds.begin(3)
    assert rounds.acted == [2], "the world waits, and counts a missed deadline"
    rounds.begin(4)
    assert rounds.acted == [2, 4]


@pytest.mark.parametrize("before", [[], [2]], ids=["within a round", "between two"])
def test_a_commander_that_is_restarted_costs_one_deadline_however_fast_it_is(rounds, before):
    rounds.begin(1)
    rounds.orders.give(1)
    for _ in before:
        rounds.orders.give(1, epoch=2)
    rounds.begin(2)
    rounds.orders.give(2, epoch=2)
    assert rounds.acted == [1], "the world waits, and counts a missed deadline"
    rounds.begin(3)
    assert rounds.acted == [1], "it is waited for as before"
    rounds.orders.give(3, epoch=2)
    assert rounds.acted == [1, 3]


def test_a_commander_that_is_restarted_in_a_pause_costs_nothing(rounds):
    rounds.begin(1, look=True)
    rounds.orders.give(1)
    rounds.orders.give(1, epoch=2)
    rounds.begin(2)
    rounds.orders.give(2, epoch=2)
    assert rounds.acted == [1, 2]
