"""What is wrong with an agent is shown as long as it lasts, whatever succeeds meanwhile."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs import msg, srv
from rclpy.parameter import Parameter

from hitab_agent import command_receiver
from hitab_agent.agent_node import AgentNode
from hitab_core.domain import BasicBehavior, Domain, Feature
from hitab_ros import names, qos


class Body:
    """A body that perceives one number, and cannot act on demand."""

    def __init__(self, name: str) -> None:
        self.values: Any = ()
        self.broken = False

    def sense(self, values: Any, heard: Any) -> None:
        self.values = values

    def act(self) -> Any:
        if self.broken:
            raise RuntimeError("the motors are gone")
        return (1.0,), ""


DOMAIN = Domain.of(
    "bodies",
    "1",
    Body,
    behaviors=[BasicBehavior("Go"), BasicBehavior("Wait")],
    features=[Feature("X", lambda body: body.values[0])],
)


class BodyNode(AgentNode):
    """The node of a body."""

    def load_domain(self, name: str) -> Domain:
        return DOMAIN


class One:
    """One agent, and what is needed to talk to it."""

    def __init__(self, process: Any, folder: Path) -> None:
        self.process = process
        self.node = node = BodyNode(
            namespace="/one",
            context=process.node.context,
            parameter_overrides=[Parameter("state_dir", value=str(folder))],
            use_global_arguments=False,
        )
        process.add(node)
        node.join()
        self.status = msg.AgentStatus()
        desk = process.node
        desk.create_subscription(msg.AgentStatus, f"/one/{names.STATUS}", self._hear, qos.LATCHED)
        self._percepts = desk.create_publisher(msg.Percept, f"/one/{names.PERCEPT}", qos.CYCLE)
        self._commands = desk.create_publisher(msg.Command, f"/one/{names.COMMAND}", qos.EVENTS)
        process.until(lambda: self._percepts.get_subscription_count())
        process.until(lambda: self._commands.get_subscription_count())
        process.until(lambda: self.status.agent)
        self._cycle = 0

    def _hear(self, status: msg.AgentStatus) -> None:
        self.status = status

    def perceive(self, *values: float) -> None:
        self._cycle += 1
        self._percepts.publish(msg.Percept(cycle=self._cycle, values=values))
        self.process.until(lambda: self.node.agent.cycle == self._cycle)

    def command(self, behavior: str) -> None:
        self._cycle += 1
        number = self._cycle
        self._commands.publish(msg.Command(sequence=number, behavior=behavior, demonstrator="me"))
        self.process.until(
            lambda: (
                number in (self.status.last_command_sequence, self.status.last_refused_sequence)
            )
        )

    def ask(self, kind: Any, service: str, **fields: Any) -> Any:
        client = self.process.node.create_client(kind, f"/one/{service}")
        self.process.until(client.service_is_ready)
        future = client.call_async(kind.Request(**fields))
        self.process.until(future.done)
        return future.result()


@pytest.fixture
def one(process: Any, tmp_path: Path) -> Iterator[One]:
    return One(process, tmp_path)


def test_features_that_are_read_before_the_first_percept_have_no_value(one):
    # This ended the process.
    answer = one.ask(srv.ReadFeatures, names.READ_FEATURES, also=["X"])
    assert answer.success
    assert [(r.feature, str(r.value)) for r in answer.readings] == [("X", "nan")]
    assert not one.status.faults


def test_an_agent_that_does_nothing_says_so_until_it_acts_whatever_is_commanded(one):
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
    one.perceive(1.0)
    one.node.agent.body.broken = True
    one.perceive(1.0)
    one.process.until(lambda: one.status.faults)
    one.command("Go")  # which succeeds
    why = "one has done nothing since cycle 2: RuntimeError"
    assert one.status.faults[0].startswith(why)
    assert one.status.last_error.startswith(why)  # what viewers show that know no faults
    one.command("Dance")
    assert 'unknown behavior "Dance"' in one.status.last_error
    assert one.status.faults[0].startswith(why)
    one.command("Wait")
    assert one.status.last_error.startswith(why)
    one.node.agent.body.broken = False
    one.perceive(1.0)
    one.process.until(lambda: not one.status.faults)
    assert not one.status.last_error


def test_what_is_not_performed_any_more_is_no_fault_any_more(one):
    one.ask(srv.Perform, names.PERFORM, behavior="Go")
    one.node.agent.body.broken = True
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
        one._commands.publish(command)
    assert one.ask(srv.ReadFeatures, names.READ_FEATURES, also=["X"]).success
    assert one.status.last_command_sequence == one.status.last_refused_sequence == 0
    one.perceive(1.0)
    for _ in range(2):
        one._commands.publish(command)
    one.process.until(lambda: one.status.last_command_sequence == 7)
    assert one.ask(srv.ReadFeatures, names.READ_FEATURES, also=["X"]).success
    assert one.node.agent.session.examples[-1].next_state == "Go"
    assert len(one.node.agent.session.examples) == 2


def test_who_never_perceives_anything_refuses_a_command_in_the_end(one, monkeypatch):
    one.ask(srv.BeginTraining, names.BEGIN, automaton="A", features=["X"])
    monkeypatch.setattr(command_receiver, "time", SimpleNamespace(monotonic=lambda: math.inf))
    one.command("Go")
    assert "nothing perceived yet" in one.status.last_error
