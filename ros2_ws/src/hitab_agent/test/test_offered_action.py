"""An agent offers its behaviors as one action, which a real client calls here."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from action_msgs.msg import GoalStatus
from bodies import Body
from hitab_msgs import msg
from hitab_msgs.action import Perform
from rclpy.action import ActionClient, get_action_server_names_and_types_by_node

from hitab_core import START, Automaton, BasicBehavior, Domain, Feature, HandWritten, Target, Term
from hitab_core.operations import BeginTraining
from hitab_ros import GuardedNode, qos
from hitab_ros.messages.conversions import pairs_message

_choose = HandWritten(
    lambda x: "Done" if x == 1.0 else "Failed" if x == 2.0 else "Wait" if x < 0.0 else "Go", (0,)
)
DOMAIN = Domain.of(
    "bodies",
    "1",
    Body,
    behaviors=[BasicBehavior("Go"), BasicBehavior("Wait"), BasicBehavior("To", parameters=("P",))],
    features=[Feature("X", lambda body: body.x)],
    targets=[Target("home", lambda body: 0.0)],
    automata=[
        Automaton(
            "Walk",
            (Term("Go"), Term("Wait"), Term("Done"), Term("Failed")),
            (Term("X"),),
            dict.fromkeys((START, "Go", "Wait"), _choose),
        )
    ],
)


class Offering:
    """One agent that offers its action, and a client."""

    def __init__(self, start: Any, **parameters: Any) -> None:
        self.one = one = start(DOMAIN, offer_actions=True, **parameters)
        self.process, self.node, self.agent, self.tick = (
            one.process,
            one.node,
            one.agent,
            one.perceive,
        )
        self.robot = GuardedNode("other", context=one.process.node.context)
        one.process.add(self.robot)
        self.client = ActionClient(self.robot, Perform, "/one/perform_until_done")
        one.process.until(self.client.server_is_ready)
        self.feedback: list[Perform.Feedback] = []

    def ask(self, behavior: str, *targets: str) -> Any:
        """Send a goal; return its handle and the future of its result."""
        sent = self.client.send_goal_async(
            Perform.Goal(behavior=behavior, targets=targets),
            lambda message: self.feedback.append(message.feedback),
        )
        self.process.until(sent.done)
        handle = sent.result()
        assert handle.accepted
        return handle, handle.get_result_async()

    def come_of(self, result: Any) -> tuple[int, str, str]:
        self.process.until(result.done)
        answer = result.result()
        return answer.status, answer.result.outcome, answer.result.message


@pytest.fixture
def make(start: Any) -> Iterator[Callable[..., Offering]]:
    made: list[Offering] = []

    def make_one(**parameters: Any) -> Offering:
        made.append(Offering(start, **parameters))
        return made[-1]

    yield make_one
    for one in made:
        one.client.destroy()


@pytest.fixture
def one(make: Callable[..., Offering]) -> Offering:
    return make()


@pytest.mark.parametrize(
    ("x", "come"),
    [
        (1.0, (GoalStatus.STATUS_SUCCEEDED, "done", '"Walk" raised Done')),
        (2.0, (GoalStatus.STATUS_ABORTED, "failed", '"Walk" raised Failed')),
    ],
)
def test_a_goal_lasts_until_the_behavior_raises_a_flag_with_feedback_on_the_way(one, x, come):
    _, result = one.ask("Walk")
    one.process.until(lambda: one.agent.behavior == "Walk")
    one.tick(0.0)
    one.process.until(lambda: one.feedback and one.feedback[-1].active_path == ["Go"])
    one.tick(0.0)
    one.tick(-1.0)
    one.process.until(lambda: one.feedback[-1].active_path == ["Wait"])
    assert one.feedback[-1].cycle == 3
    one.tick(x)
    assert one.come_of(result) == come
    assert one.agent.mode == "idle"


def test_a_canceled_goal_leaves_the_agent_at_rest(one):
    handle, result = one.ask("To", "home")
    one.process.until(lambda: one.agent.behavior == "To(home)")
    canceling = handle.cancel_goal_async()
    one.process.until(canceling.done)
    assert len(canceling.result().goals_canceling) == 1
    assert one.come_of(result) == (GoalStatus.STATUS_CANCELED, "", "canceled")
    assert one.agent.mode == "idle"


def test_a_new_goal_replaces_the_one_before(one):
    _, first = one.ask("Walk")
    _, second = one.ask("Go")
    aborted = (GoalStatus.STATUS_ABORTED, "replaced", '"Go" was asked for')
    assert one.come_of(first) == aborted
    one.agent.perform(Term("Wait"))
    one.tick(0.0)
    replaced = (GoalStatus.STATUS_ABORTED, "replaced", 'one is performing "Wait"')
    assert one.come_of(second) == replaced
    assert one.agent.behavior == "Wait"


@pytest.mark.parametrize(
    ("goal", "why"),
    [
        (("Wlak",), 'Did you mean "Walk"'),
        (("To",), "To"),
        (("To", "hom"), 'Did you mean "home"'),
        (("x" * 1001,), "the limit is 1000"),
    ],
)
def test_a_goal_that_cannot_be_performed_is_aborted_with_the_reason(one, goal, why):
    status, outcome, message = one.come_of(one.ask(*goal)[1])
    assert (status, outcome) == (GoalStatus.STATUS_ABORTED, "")
    assert why in message
    assert one.node.status.message.last_error == message
    assert one.agent.mode == "idle"


def test_a_training_that_begins_replaces_the_goal_and_has_others_refused(one):
    _, result = one.ask("Go")
    one.one.do(BeginTraining("New", ["X"]))
    replaced = (GoalStatus.STATUS_ABORTED, "replaced", 'one is training "New"')
    assert one.come_of(result) == replaced
    status, outcome, message = one.come_of(one.ask("Walk")[1])
    assert (status, outcome) == (GoalStatus.STATUS_ABORTED, "")
    assert message == 'it is training "New"; save the training of one; make one idle'
    assert one.agent.training == "New"


def order_of(behavior: str, sequence: int) -> msg.Order:
    return msg.Order(
        commander="chief",
        epoch=1,
        sequence=sequence,
        order=behavior,
        behaviors=pairs_message([("", behavior)]),
    )


def test_after_a_goal_the_agent_performs_what_its_commander_has_ordered(make, process):
    one = make(commander="chief")
    orders = one.robot.create_publisher(msg.Order, "/chief/order", qos.LATCHED)
    orders.publish(order_of("Wait", 1))
    process.until(lambda: one.agent.behavior == "Wait")
    _, result = one.ask("Walk")
    process.until(lambda: one.agent.behavior == "Walk")
    one.tick(1.0)
    assert one.come_of(result)[1] == "done"
    assert one.agent.behavior == "Wait"
    handle, result = one.ask("Walk")
    canceling = handle.cancel_goal_async()
    process.until(canceling.done)
    assert one.come_of(result)[0] == GoalStatus.STATUS_CANCELED
    assert one.agent.behavior == "Wait"
    _, result = one.ask("Walk")
    orders.publish(order_of("Go", 2))
    assert one.come_of(result)[1] == "replaced"
    assert one.agent.behavior == "Go"


def test_an_agent_does_not_offer_its_action_unless_asked(start):
    node = start(DOMAIN).node
    assert get_action_server_names_and_types_by_node(node, node.get_name(), "/one") == []
