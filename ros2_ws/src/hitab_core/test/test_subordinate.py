"""A subordinate obeys orders; what it cannot obey waits, and says why."""

from hitab_core.agent import Agent, Mode
from hitab_core.behavior_library import BehaviorLibrary
from hitab_core.domain import BasicBehavior, Domain
from hitab_core.order import OTHERS, Order
from hitab_core.subordinate import Subordinate


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


def test_a_behavior_that_fails_to_start_does_not_end_the_agent_and_is_told(tmp_path):
    agent = Agent("cart", CART, BehaviorLibrary(tmp_path, CART))
    subordinate = Subordinate(agent)
    assert subordinate.take(Order(1, 1, "Go", {OTHERS: "Drive"}))
    assert subordinate.waits
    assert 'cannot obey the order "Go": IndexError' in subordinate.refusal
    assert subordinate.take(Order(1, 2, "Halt", {OTHERS: "Park"}))
    assert (agent.mode, agent.behavior, subordinate.refusal) == (Mode.PERFORMING, "Park", "")
