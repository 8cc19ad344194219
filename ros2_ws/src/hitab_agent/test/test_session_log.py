"""An agent tells what it takes in while somebody records, and only then."""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg

from hitab_core import BasicBehavior, Domain, Feature
from hitab_ros import names, qos, session_topics
from hitab_ros.testing import NumberBody

DOMAIN = Domain.of(
    "told",
    "1",
    NumberBody,
    behaviors=[BasicBehavior("Go")],
    features=[Feature("X", lambda body: body.x)],
)


def test_one_who_records_gets_what_the_agent_knows_and_then_all_that_it_takes_in(start):
    one = start(DOMAIN)
    process = one.process
    one.perceive()
    one.perceive()
    offered = {publisher.topic_name for publisher in one.node.publishers}
    assert offered.isdisjoint(f"/one/{name}" for name in session_topics.TOPICS)

    told: list[tuple[str, Any]] = []
    for name, kind in session_topics.TOPICS.items():
        process.node.create_subscription(
            kind, f"/one/{name}", lambda m, name=name: told.append((name, m)), qos.EVENTS
        )
    process.until(lambda: len(told) == 2)
    said = dict(told)
    assert said[session_topics.KNOWN].digest == one.agent.edition.digest
    assert said[session_topics.PERCEIVED].cycle == 2

    told.clear()
    one.perceive()
    for _ in range(2):  # sent again, as by a demonstrator whose acknowledgement was late
        one.commands.publish(msg.Command(sequence=5, behavior="Nonsense"))
        process.until(lambda: one.node.status.message.last_refused_sequence == 5)
    kind = session_topics.SERVICES[names.BEGIN]
    one.ask(kind, names.BEGIN, automaton="Near", features=["X"])
    process.until(lambda: session_topics.REQUESTED in dict(told))
    assert len(told) == 3
    said = dict(told)
    assert said[session_topics.PERCEIVED].cycle == 3
    assert said[session_topics.COMMANDED].sequence == 5
    request = session_topics.request_of(said[session_topics.REQUESTED].data)[1]
    assert request.automaton == "Near"
