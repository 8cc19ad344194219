"""What is wrong with an agent is shown as long as it lasts, whatever succeeds meanwhile."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from bodies import UnseeingBody
from hitab_msgs import msg, srv

from hitab_agent import command_receiver
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_ros import names


def read(body):
    return body.values[0]


DOMAIN = Domain.of(
    "bodies",
    "1",
    UnseeingBody,
    behaviors=[BasicBehavior("Go"), BasicBehavior("Wait")],
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
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
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
    one.ask(srv.Perform, names.PERFORM, behavior="Go")
    one.body.act = lambda: 1 / 0
    one.perceive(1.0)
    one.process.until(lambda: one.status.faults)
    one.ask(srv.SetMode, names.SET_MODE, mode="idle")
    one.process.until(lambda: not one.status.faults)


def test_a_callback_that_fails_is_a_fault_until_it_succeeds(one):
    status = one.node.status
    report, status.report_error = status.report_error, lambda text: 1 / 0
    one.command("Go")
    one.process.until(lambda: one.status.faults)
    assert "topic command failed: ZeroDivisionError" in one.status.faults[0]
    status.report_error = report
    one.command("Go")
    one.process.until(lambda: not one.status.faults)


def test_a_command_before_the_first_percept_is_obeyed_once_it_is_sent_again(one):
    """An agent restarted in a paused world was commanded before it was shown the world again."""
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
    command = msg.Command(sequence=7, behavior="Go", demonstrator="me")
    for _ in range(2):
        one.commands.publish(command)
    assert one.ask(srv.ReadFeatures, names.READ_FEATURES, also=["X"]).success
    assert one.status.last_command_sequence == one.status.last_refused_sequence == 0
    one.perceive(1.0)
    for _ in range(2):
        one.commands.publish(command)
    one.process.until(lambda: one.status.last_command_sequence == 7)
    assert one.ask(srv.ReadFeatures, names.READ_FEATURES, also=["X"]).success
    assert one.agent.session.examples[-1].next_state == "Go"
    assert len(one.agent.session.examples) == 2


def test_who_never_perceives_anything_refuses_a_command_in_the_end(one, monkeypatch):
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
    monkeypatch.setattr(command_receiver, "time", SimpleNamespace(monotonic=lambda: math.inf))
    one.command("Go")
    assert "nothing perceived yet" in one.status.last_error


def test_demonstrators_who_command_at_the_same_time_are_told_of_each_other(one, monkeypatch):
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
    one.perceive(1.0)
    one.command("Go", "Bert")
    assert one.status.note == ""
    one.command("Wait", "Anna")
    together = "is commanded by Anna and Bert at the same time"
    assert one.status.note == together
    one.command("Go", "Bert")
    assert one.status.note == together
    monkeypatch.setattr(command_receiver, "TOGETHER_S", 0.0)
    one.command("Wait", "Anna")
    assert one.status.note == "", "Bert has left"


def test_undo_and_redo_say_what_is_undone_and_redone(one):
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
    one.perceive(1.0)
    one.command("Go")
    edits = srv.EditExamples.Request
    undone = one.ask(srv.EditExamples, names.EDIT_EXAMPLES, action=edits.UNDO)
    assert undone.message == 'undone: Start → Go, 2 examples; "A" has 0 examples'
    redone = one.ask(srv.EditExamples, names.EDIT_EXAMPLES, action=edits.REDO)
    assert redone.message == 'redone: Start → Go, 2 examples; "A" has 2 examples'
