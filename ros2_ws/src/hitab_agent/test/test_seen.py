"""What ROS's own tools see of an agent: its log, its parameters, what is wrong with it."""

from __future__ import annotations

import math
from typing import Any

import pytest
from bodies import Body
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.msg import Log
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.logging import LoggingSeverity
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_sensor_data

from hitab_agent.host_resources import HostResources
from hitab_core import (
    START,
    Automaton,
    BasicBehavior,
    Domain,
    Example,
    Feature,
    HitabError,
    Term,
    TransitionTree,
)
from hitab_core.operations import Perform
from hitab_ros.nodes.diagnostics import STATUSES_MAX, Diagnosis, Level, shown


def _automaton() -> Automaton:
    shown = [(-2.0, "Wait"), (-1.0, "Wait"), (1.0, "Go"), (2.0, "Go")]
    tree = TransitionTree().fit([[x] for x, _ in shown], [after for _, after in shown])
    states = (START, "Go", "Wait")
    return Automaton(
        "Choose",
        (Term("Go"), Term("Wait")),
        (Term("X"),),
        dict.fromkeys(states, tree),
        examples=tuple(Example(state, (x,), after) for state in states for x, after in shown),
    )


DOMAIN = Domain.of(
    "bodies",
    "1",
    Body,
    behaviors=[BasicBehavior("Go"), BasicBehavior("Wait")],
    features=[Feature("X", lambda body: body.x)],
    automata=[_automaton()],
)


class Shown:
    """One agent, and what is said of it on ROS's own topics."""

    def __init__(self, start: Any) -> None:
        self.one = one = start(DOMAIN)
        self.process, self.node = one.process, one.node
        self.ask, self.tick = one.ask, one.perceive
        self.diagnosis = DiagnosticStatus()
        self.process.node.create_subscription(DiagnosticArray, "/diagnostics", self._hear, 10)

    def _hear(self, array: DiagnosticArray) -> None:
        (self.diagnosis,) = array.status

    def shows(self, level: Level, text: str) -> None:
        """Wait until the diagnosis has this level, and a message with this text."""
        self.process.until(
            lambda: self.diagnosis.level == bytes([level]) and text in self.diagnosis.message
        )


@pytest.fixture
def one(start: Any) -> Shown:
    return Shown(start)


def test_the_diagnosis_of_an_agent_has_the_worst_of_what_is_wrong(one):
    one.shows(Level.STALE, "nothing perceived yet")
    assert (one.diagnosis.name, one.diagnosis.hardware_id) == ("hitab: one", "/one")
    one.one.do(Perform("Choose"))
    one.tick(1.0)
    one.shows(Level.OK, 'performing "Choose"')
    values = {value.key: value.value for value in one.diagnosis.values}
    assert values["active states"] == "Go"
    one.tick(math.nan)
    one.shows(Level.WARN, 'feature "X" has no value')
    one.one.body.act = lambda: 1 / 0
    one.tick(1.0)
    one.shows(Level.ERROR, "ZeroDivisionError")
    del one.one.body.act
    one.tick(1.0)
    one.shows(Level.OK, "performing")


def test_the_parameters_of_an_agent_can_be_read_but_not_changed(one):
    listed = one.ask(ListParameters, "agent/list_parameters")
    every = one.ask(GetParameters, "agent/get_parameters", names=listed.result.names)
    assert len(every.values) == len(listed.result.names), "for `ros2 param dump`"
    change = Parameter("world", value="moon").to_parameter_msg()
    answer = one.ask(SetParameters, "agent/set_parameters", parameters=[change])
    assert not answer.results[0].successful


def test_changes_of_state_are_logged_while_somebody_listens(one):
    logged: list[Log] = []
    one.one.do(Perform("Choose"))
    one.tick(1.0)
    listener = one.process.node.create_subscription(
        Log, "/rosout", logged.append, qos_profile_sensor_data, temporary=True
    )
    one.process.until(lambda: one.node.count_subscribers("/rosout"))

    def is_told() -> bool:
        one.node.transition_log.look()
        one.tick(-1.0)
        one.tick(1.0)
        return any("one: Choose: Wait -> Go (X > " in line.msg for line in logged)

    one.process.until(is_told)
    assert all(line.level == LoggingSeverity.INFO for line in logged if "Choose: " in line.msg)
    one.process.node.destroy_subscription(listener)


def test_a_host_tells_of_all_its_agents_in_one_message_and_of_none_in_rosout(process, start):
    shared = HostResources(process.node, is_host=True, on_demand=True)
    arrays: list[DiagnosticArray] = []
    process.node.create_subscription(DiagnosticArray, "/diagnostics", arrays.append, 10)
    nodes = [start(DOMAIN, name, shared=shared).node for name in ("a", "b", "c")]
    nodes[0].agent.sense([1.0], [])
    nodes[0].status.report_error(HitabError("no such behavior"))
    process.until(lambda: arrays and len(arrays[-1].status) == 4)
    summary, *others = arrays[-1].status
    assert summary.message == "1 WARN, 2 STALE"
    assert {value.key: value.value for value in summary.values}["agents"] == "3"
    assert [one.level for one in others] == [bytes([Level.STALE])] * 2 + [bytes([Level.WARN])]
    # Of these nodes: those of earlier tests may still be in the graph.
    publishers = process.node.get_publishers_info_by_topic("/rosout")
    assert {info.node_namespace for info in publishers}.isdisjoint({"/a", "/b", "/c"})
    offered = {name for name, _ in nodes[0].get_service_names_and_types()}
    assert "/a/agent/list_parameters" not in offered


def test_of_many_agents_a_message_shows_the_worst():
    asked = []

    def diagnosis(name: str, *found: tuple[Level, str]) -> Diagnosis:
        return Diagnosis(name, f"/{name}", found, lambda: (asked.append(name), ("fine", {}))[1])

    fine = [diagnosis(f"ok_{i}") for i in range(1000)]
    assert [one.message for one in shown(fine, "/host")] == ["1000 OK"]
    assert not asked  # with a thousand agents, the details of all would take their time
    ill = [diagnosis(f"a_{i}", (Level.WARN, "ill")) for i in range(100)]
    dead = [diagnosis("d", (Level.STALE, "?"), (Level.ERROR, "dead"))]
    summary, first, *rest = shown(fine + ill + dead, "/host")
    assert (summary.level, summary.message) == (bytes([Level.ERROR]), "1000 OK, 100 WARN, 1 ERROR")
    assert (first.name, first.message) == ("hitab: d", "dead (and 1 more)")
    assert len(rest) == STATUSES_MAX - 1
