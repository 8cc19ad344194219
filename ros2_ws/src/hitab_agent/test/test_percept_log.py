"""An agent publishes what it perceives while somebody records it, and only then."""

from __future__ import annotations

from bodies import Body
from hitab_msgs import msg

from hitab_core import BasicBehavior, Domain, Feature
from hitab_ros import qos

DOMAIN = Domain.of(
    "told",
    "1",
    Body,
    behaviors=[BasicBehavior("Go")],
    features=[Feature("X", lambda body: body.x)],
)


def test_a_recorder_gets_the_last_percept_and_then_each_one(start):
    one = start(DOMAIN)
    process = one.process
    one.perceive()
    one.perceive()
    assert "/one/perceived" not in {publisher.topic_name for publisher in one.node.publishers}

    told: list[int] = []
    process.node.create_subscription(
        msg.Percept, "/one/perceived", lambda percept: told.append(percept.cycle), qos.EVENTS
    )
    process.until(lambda: told == [2])
    one.perceive()
    process.until(lambda: told == [2, 3])
