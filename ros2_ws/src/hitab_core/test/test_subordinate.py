"""A subordinate obeys orders; what it cannot obey waits, and says why."""

from hitab_core.agent import Agent, Mode
from hitab_core.commanding.order import OTHERS, Order
from hitab_core.commanding.subordinate import Subordinate
from hitab_core.domain import BasicBehavior, Domain
from hitab_core.library.behavior_library import BehaviorLibrary


class Cart:
    """A body that needs a percept before it can drive."""

    values: tuple[float, ...] = ()

    def sense(self, values, heard):
        self.values = tuple(values)

    def act(self):
        return (), ""


def _drive(body):
    return body.values[0]


CART = Domain.of(
    "cart",
    "1",
    lambda name: Cart(),
    behaviors=[BasicBehavior("Drive", start=_drive), BasicBehavior("Park")],
    features=[],
)


def test_a_behavior_that_fails_to_start_waits_and_tells_why_until_it_can_be_started(tmp_path):
    agent = Agent("cart", CART, BehaviorLibrary(tmp_path, CART))
    subordinate = Subordinate(agent)
    assert subordinate.take(Order(1, 1, "Go", {OTHERS: "Drive"}))
    assert subordinate.waits
    assert subordinate.refusal.startswith('cannot obey the order "Go": nothing perceived yet; ')
    assert agent.mode is Mode.IDLE
    agent.sense((1.0,), ())
    assert subordinate.settle()
    assert (agent.mode, agent.behavior, subordinate.refusal) == (Mode.PERFORMING, "Drive", "")
