"""What is wrong with an agent is shown as long as it lasts, whatever succeeds meanwhile."""

from __future__ import annotations

import pytest
from bodies import UnseeingBody
from hitab_msgs import msg, srv

from hitab_agent.topics import status_publisher
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_core.operations import BeginTraining, Command, Perform, Redo, Undo
from hitab_ros import names, qos


def read(body):
    return body.values[0]


def fall(body):
    raise RuntimeError("fallen over")


DOMAIN = Domain.of(
    "bodies",
    "1",
    UnseeingBody,
    behaviors=[BasicBehavior("Go"), BasicBehavior("Wait"), BasicBehavior("Fall", start=fall)],
    features=[Feature("X", read)],
)


@pytest.fixture
def one(start):
    return start(DOMAIN)


def test_features_that_are_read_before_the_first_percept_have_no_value(one):
    # This ended the process.
    answer = one.ask(srv.ReadFeatures, names.READ_FEATURES, also=["X"])
    assert answer.success
    assert [(r.feature, str(r.value)) for r in answer.readings] == [("X", "nan")]
    assert not one.status.faults


def test_an_agent_that_does_nothing_says_so_until_it_acts_whatever_is_commanded(one):
    one.do(BeginTraining("A", ["X"]))
    one.perceive(1.0)
    one.body.act = lambda: 1 / 0
    one.perceive(1.0)
    one.process.until(lambda: one.status.faults)
    one.command("Go")  # which succeeds
    why = "one has done nothing since cycle 2: ZeroDivisionError"
    assert one.status.faults[0].startswith(why)
    assert one.status.last_error.startswith(why)  # what viewers show that know no faults
    one.command("Dance")
    assert 'unknown behavior "Dance"' in one.status.last_error
    assert one.status.faults[0].startswith(why)
    one.command("Wait")
    assert one.status.last_error.startswith(why)
    del one.body.act
    one.perceive(1.0)
    one.process.until(lambda: not one.status.faults)
    assert not one.status.last_error


def test_what_is_not_performed_any_more_is_no_fault_any_more(one):
    one.do(Perform("Go"))
    one.body.act = lambda: 1 / 0
    one.perceive(1.0)
    one.process.until(lambda: one.status.faults)
    one.do(Perform())
    one.process.until(lambda: not one.status.faults)


@pytest.fixture
def commands(one):
    """Return the topic for commands that need no answer."""
    topic = one.process.node.create_publisher(msg.Command, f"/one/{names.COMMAND}", qos.EVENTS)
    one.process.until(topic.get_subscription_count)
    return topic


def test_a_callback_that_fails_is_a_fault_until_it_succeeds(one, commands):
    status = one.node.status
    report, status.report_error = status.report_error, lambda text: 1 / 0
    commands.publish(msg.Command(behavior="Go"))
    one.process.until(lambda: one.status.faults)
    assert "topic command failed: ZeroDivisionError" in one.status.faults[0]
    status.report_error = report
    commands.publish(msg.Command(behavior="Go"))
    one.process.until(lambda: not one.status.faults)


def test_the_status_shows_what_became_of_a_command_on_the_topic(one, commands):
    one.do(BeginTraining("A", ["X"]))
    refused = {"Dance": 'unknown behavior "Dance"', "Go\x1b": "has control characters"}
    one.perceive(1.0)
    for behavior, why in refused.items():
        commands.publish(msg.Command(behavior=behavior))
        one.process.until(lambda why=why: why in one.status.last_error)
        assert not one.status.faults, "the mistake is the sender's"
    for _ in range(2):
        commands.publish(msg.Command(behavior="Go", id="once", by="me"))
    one.process.until(lambda: one.status.training.examples)
    assert not one.status.last_error
    assert one.command("Wait").status.training.examples == 4


def test_a_command_before_the_first_percept_is_refused_and_obeyed_when_it_is_sent_again(one):
    """An agent restarted in a paused world is commanded before it is shown the world again."""
    one.do(BeginTraining("A", ["X"]))
    command = Command("Go", id="7", by="me")
    for _ in range(2):
        refused = one.do(command)
        assert (refused.success, refused.status.perceived) == (False, False)
        assert "nothing perceived yet" in refused.message
    one.perceive(1.0)
    for _ in range(2):
        answer = one.do(command)
        assert answer.success
        assert (list(answer.examples), answer.left) == ([1, 2], "Start")
        assert answer.status.training.examples == 2


def test_what_was_recorded_is_not_recorded_again_though_its_behavior_could_not_be_begun(one):
    one.do(BeginTraining("A", ["X"]))
    one.perceive(1.0)
    command = Command("Fall", id="8")
    for _ in range(2):
        assert "fallen over" in one.do(command).message
        assert len(one.agent.session.examples) == 2


def test_demonstrators_who_command_at_the_same_time_are_told_of_each_other(one, monkeypatch):
    one.do(BeginTraining("A", ["X"]))
    one.perceive(1.0)
    one.command("Go", "Bert")
    assert one.status.note == ""
    one.command("Wait", "Anna")
    together = "is commanded by Anna and Bert at the same time"
    assert one.status.note == together
    one.command("Go", "Bert")
    assert one.status.note == together
    monkeypatch.setattr(status_publisher, "TOGETHER_S", 0.0)
    one.command("Wait", "Anna")
    assert one.status.note == "", "Bert has left"


def test_undo_and_redo_say_what_is_undone_and_redone(one):
    one.do(BeginTraining("A", ["X"]))
    one.perceive(1.0)
    one.command("Go")
    undone, redone = one.do(Undo()), one.do(Redo())
    assert undone.message == 'undone: Start → Go, 2 examples; "A" has 0 examples'
    assert redone.message == 'redone: Start → Go, 2 examples; "A" has 2 examples'
