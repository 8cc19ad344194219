"""An agent tells what it takes in while somebody records, and only then."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hitab_msgs import msg
from rclpy.parameter import Parameter
from std_msgs.msg import String

from hitab_agent.agent_node import AgentNode
from hitab_core import BasicBehavior, Domain, Feature
from hitab_ros import names, qos, session_topics
from hitab_ros.testing import NumberBody


class Body(NumberBody):
    """It does what it perceives."""

    def act(self) -> Any:
        return (self.x,), ""


DOMAIN = Domain.of(
    "told",
    "1",
    Body,
    behaviors=[BasicBehavior("Go")],
    features=[Feature("X", lambda body: body.x)],
)


@pytest.fixture
def agent(process: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AgentNode:
    monkeypatch.setattr("hitab_agent.shared.load_domain", lambda name: DOMAIN)
    settings = {"domain": "told", "state_dir": str(tmp_path)}
    node = AgentNode(
        context=process.node.context,
        namespace="/one",
        parameter_overrides=[Parameter(key, value=value) for key, value in settings.items()],
    )
    process.add(node)
    node.join()
    return node


def perceive(process: Any, agent: AgentNode, publisher: Any, cycle: int) -> None:
    publisher.publish(msg.Percept(sequence=cycle, cycle=cycle, values=[float(cycle)]))
    process.until(lambda: agent.agent.cycle == cycle)


def topics_of(agent: AgentNode) -> set[str]:
    return {publisher.topic_name for publisher in agent.publishers} & {
        f"/one/{name}" for name in session_topics.TOPICS
    }


def test_one_who_records_first_gets_what_the_agent_knows_and_perceived_last(
    process: Any, agent: AgentNode
) -> None:
    node = process.node
    percepts = node.create_publisher(msg.Percept, f"/one/{names.PERCEPT}", qos.CYCLE)
    commands = node.create_publisher(msg.Command, f"/one/{names.COMMAND}", qos.EVENTS)
    process.until(lambda: percepts.get_subscription_count() and commands.get_subscription_count())
    perceive(process, agent, percepts, 1)
    perceive(process, agent, percepts, 2)
    assert topics_of(agent) == set()

    told: list[tuple[str, Any]] = []
    for name, kind in session_topics.TOPICS.items():
        node.create_subscription(
            kind, f"/one/{name}", lambda m, name=name: told.append((name, m)), qos.EVENTS
        )
    process.until(lambda: len(told) == 2)
    said = dict(told)
    assert said[session_topics.KNOWN].digest == agent.agent.edition.digest
    assert said[session_topics.PERCEIVED].cycle == 2

    told.clear()
    perceive(process, agent, percepts, 3)
    commands.publish(msg.Command(sequence=5, behavior="Nonsense"))
    process.until(lambda: len(told) == 2)
    said = dict(told)
    assert said[session_topics.PERCEIVED].cycle == 3
    assert said[session_topics.COMMANDED].sequence == 5


def test_a_request_is_told_before_it_is_served(process: Any, agent: AgentNode) -> None:
    node = process.node
    told: list[str] = []
    known: list[Any] = []

    def take(request: String) -> None:
        told.append(session_topics.request_of(request.data)[1].automaton)

    takers = {session_topics.REQUESTED: take, session_topics.KNOWN: known.append}
    for name, kind in session_topics.TOPICS.items():
        node.create_subscription(
            kind, f"/one/{name}", takers.get(name, lambda message: None), qos.EVENTS
        )
    kind = session_topics.SERVICES[names.BEGIN]
    client = node.create_client(kind, f"/one/{names.BEGIN}")
    process.until(lambda: known and client.service_is_ready())
    answer = client.call_async(kind.Request(automaton="Near", features=["X"]))
    process.until(answer.done)
    process.until(lambda: told == ["Near"])
