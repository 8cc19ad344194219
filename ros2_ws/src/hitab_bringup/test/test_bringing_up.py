"""Reports of `hitab up` on other swarms, and on commanders without all subordinates."""

from types import SimpleNamespace

import pytest
from hitab_msgs.msg import CommanderStatus, Subordinate

from hitab_bringup.processes import bringing_up
from hitab_client import CommanderView, RosLink, domain_ids
from hitab_client.showing.agent_presence import AgentPresence
from hitab_ros import names, qos

RECORD = SimpleNamespace(
    identity="red-0a1b2c3d", agents=("captain", "a", "b"), commanders=("captain",)
)


@pytest.fixture
def group():
    """Yield a link, and a function that sets the subordinates that the captain does not hear."""
    with domain_ids.reserved() as number, RosLink(number) as robots, RosLink(number) as link:
        topic = names.of_agent("captain", names.GROUP)
        publisher = robots.node.create_publisher(CommanderStatus, topic, qos.LATCHED)

        def publish(*silent: bool) -> None:
            publisher.publish(
                CommanderStatus(
                    commander="captain",
                    swarm=RECORD.identity,
                    subordinates=[
                        Subordinate(name=name, silent=quiet)
                        for name, quiet in zip("ab", silent, strict=True)
                    ],
                )
            )

        yield link, publish


def test_up_waits_until_commanders_hear_everybody_or_says_that_they_do_not_yet(group, monkeypatch):
    link, publish = group
    view = CommanderView(AgentPresence(link, identity=RECORD.identity))
    view.watch(RECORD.commanders)
    running = SimpleNamespace(record=RECORD, link=link, groups=view)
    monkeypatch.setattr(bringing_up, "DISCOVERY_EACH_S", 0.0)
    monkeypatch.setattr(bringing_up, "ANSWER_S", 0.1)
    publish(False, True)
    (said,) = bringing_up._await_commanders(running, None)
    assert said.startswith("captain does not hear all subordinates yet")
    monkeypatch.setattr(bringing_up, "ANSWER_S", 60.0)
    seen = []

    def progress(done: int, total: int, missing: str) -> None:
        seen.append((done, total, missing))
        publish(False, len(seen) < 3)

    assert list(bringing_up._await_commanders(running, progress)) == []
    assert seen[0] == (0, 1, "captain")
    assert seen[-1] == (1, 1, "")
