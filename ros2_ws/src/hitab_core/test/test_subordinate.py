"""A subordinate obeys orders; an order that cannot be obeyed waits, with a reason."""

import math

from hypothesis import given
from hypothesis import strategies as st

from hitab_core.agent import Agent
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.library.behavior_library import BehaviorLibrary
from hitab_core.orders.order import ALL_OTHERS, Order
from hitab_core.orders.subordinate import Subordinate
from hitab_core.running.mode import Mode
from hitab_core.term import Term
from hitab_core.training import Curriculum


class Cart:
    """A body that needs a percept before it can drive."""

    values: tuple[float, ...] = ()
    position = (1.0, 2.0)

    def __init__(self):
        self.started: list[str] = []

    def sense(self, values, heard):
        self.values = tuple(values)

    def act(self):
        return (), ""


def _drive(body):
    body.started.append("Drive")
    return body.values[0]


def _park(body):
    body.started.append("Park")


CART = Domain.of(
    "cart",
    "1",
    lambda name: Cart(),
    behaviors=[BasicBehavior("Drive", start=_drive), BasicBehavior("Park", start=_park)],
    features=[Feature("Speed", lambda body: body.values[0])],
)


def test_a_behavior_that_fails_to_start_waits_and_tells_why_until_it_can_be_started(tmp_path):
    agent = Agent("cart", CART, BehaviorLibrary(tmp_path, CART))
    subordinate = Subordinate(agent)
    assert subordinate.take(Order(1, 1, "Go", {ALL_OTHERS: "Drive"}))
    assert subordinate.waits
    assert subordinate.refusal.startswith('cannot obey the order "Go": nothing perceived yet; ')
    assert agent.mode is Mode.IDLE
    agent.sense((1.0,), ())
    assert subordinate.settle()
    assert (agent.mode, agent.behavior, subordinate.refusal) == (Mode.PERFORMING, "Drive", "")


ORDERS = st.builds(
    Order,
    epoch=st.integers(1, 2),
    sequence=st.integers(0, 4),
    behaviors=st.dictionaries(
        st.sampled_from(["cart", "scout", "other", ALL_OTHERS]),
        st.sampled_from(["Drive", "Park", ""]),
        max_size=3,
    ),
    round=st.integers(0, 1),
)


@given(
    events=st.lists(ORDERS | st.sampled_from(["train", "discard", "lockstep", "real time"])),
)
def test_the_newest_order_is_performed_once_training_lets_it(tmp_path_factory, events):
    agent = Agent("cart", CART, BehaviorLibrary(tmp_path_factory.mktemp("library"), CART))
    agent.sense((1.0,), ())
    subordinate = Subordinate(agent, "scout")
    newest, performs, pending, training, lockstep = (0, 0), "", None, False, False
    in_force = None
    started: list[str] = []

    def obey():
        nonlocal performs, pending
        if pending is not None and not training:
            if pending not in ("", performs):
                started.append(pending)
            performs, pending = pending, None

    for event in events:
        if isinstance(event, Order):
            number = (event.epoch, 0 if lockstep and not event.round else event.sequence)
            assert subordinate.take(event) == (number > newest)
            if number > newest:
                newest = number
                known = [
                    event.behaviors[r]
                    for r in ("cart", "scout", ALL_OTHERS)
                    if r in event.behaviors
                ]
                if number[1]:
                    pending = known[0] if known else None
                    in_force = in_force if pending is None else pending
        elif event == "train":
            agent.begin(Curriculum("Trip", (Term("Speed"),)), discard=True)
            subordinate.settle()
            training, performs, pending = True, "", in_force
        elif event == "discard" and training:
            agent.discard()
            training = False
            subordinate.settle()
        elif event == "lockstep":
            assert subordinate.round_begins(3, look=True, restart=False).look
            lockstep = True
        elif event == "real time":
            assert subordinate.rounds_end() == lockstep
            lockstep = False
        obey()
        report = subordinate.report()
        assert (report.epoch, report.sequence) == newest
        assert report.waits == subordinate.waits == (pending is not None)
        assert report.round == (3 if lockstep else 0)
        assert list(report.path) == (["Trip"] if training else [performs] * bool(performs))
        assert agent.body.started == started


def test_a_report_is_due_on_news_or_when_the_period_that_was_asked_for_is_over(tmp_path):
    agent = Agent("cart", CART, BehaviorLibrary(tmp_path, CART))
    subordinate = Subordinate(agent)
    assert subordinate.news(0.0) is not None
    assert subordinate.news(9.0) is None, "nothing is asked for and nothing has changed"
    asked = Order(1, 1, "Go", {}, ("Speed", "Height", "Speed(ball)"), True, report_period=0.5)
    subordinate.take(asked)
    assert subordinate.is_asked
    agent.sense((3.0,), (), cycle=7)
    report = subordinate.news(9.1)
    speed, *unknown = report.values
    assert (speed, report.position, report.cycle) == (3.0, (1.0, 2.0), 7)
    assert all(math.isnan(value) for value in unknown), "no such feature or target"
    assert subordinate.news(9.5) is None
    assert subordinate.news(9.6) is not None
    assert subordinate.news(2.0) is not None, "the world's time was set back"
    agent.perform(None)
    assert subordinate.heartbeat() is None, "there was a report since the last one"
    assert subordinate.heartbeat() is None, "signs of life suffice where nothing is perceived"
    agent.sense((3.0,), (), cycle=8)
    assert subordinate.heartbeat().cycle == 8
    agent.sense((3.0,), (), cycle=9)
    assert subordinate.heartbeat().cycle == 9, "a heartbeat is no news"
    agent.sense((3.0,), (), cycle=10)
    subordinate.round_begins(1, look=False, restart=False)
    assert subordinate.heartbeat() is None, "in lockstep rounds tell"
    agent.body.position = None
    assert subordinate.report().position == ()
