"""A world notices who receives its percepts."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest
from hitab_msgs import msg
from rclpy.experimental import EventsExecutor

from hitab_ros import qos
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.testing import context_of_its_own, spin_until, wait_until
from hitab_world.node.host_registry import SwarmSettings
from hitab_world.node.percept_sender import PerceptSender

HOSTS = ("ours", "theirs", "nobodys")
GRAPH_QUERIES = (
    *("count_", "get_client_names", "get_node_names", "get_publishers"),
    *("get_service_names", "get_subscri", "get_topic_names"),
)


@pytest.fixture
def nodes() -> Iterator[tuple[GuardedNode, GuardedNode]]:
    """A world's node, and that of an agent."""
    with context_of_its_own() as context:
        world = GuardedNode("world", namespace="world", context=context)
        agent = GuardedNode("agent", namespace="a", context=context)
        try:
            yield world, agent
        finally:
            agent.destroy_node()
            world.destroy_node()


def percept_reader(agent: GuardedNode) -> Any:
    """Subscribe to an agent's percepts as its process does, which then also offers to answer."""
    reader = agent.create_subscription(msg.Percept, "percept", lambda _: None, qos.CYCLE)
    agent.create_publisher(msg.Action, "/world/actions", qos.CYCLE)
    return reader


def test_who_takes_the_place_of_another_at_once_is_noticed_and_shown_the_world(nodes):
    world, agent = nodes
    sender = PerceptSender(world, ("a",))
    first = percept_reader(agent)
    wait_until(lambda: sender.has("a"))
    wait_until(lambda: not sender.look())

    def receivers() -> set[bytes]:
        ends = world.get_subscriptions_info_by_topic("/a/percept")
        return {bytes(end.endpoint_gid) for end in ends}

    before = receivers()
    percept_reader(agent)
    agent.destroy_subscription(first)
    wait_until(lambda: len(receivers()) == 1 and receivers().isdisjoint(before))
    assert sender.has("a")
    assert sender.look(), "there is as many as before, but another one"
    wait_until(lambda: not sender.look())


def test_a_killed_process_that_is_given_up_after_another_took_its_place_changes_nothing(nodes):
    world, agent = nodes
    sender = PerceptSender(world, ("a",))
    killed = percept_reader(agent)
    percept_reader(agent)
    wait_until(lambda: world.count_subscribers("/a/percept") == 2)
    wait_until(lambda: sender.has("a"))
    wait_until(lambda: not sender.look())
    agent.destroy_subscription(killed)
    wait_until(lambda: world.count_subscribers("/a/percept") == 1)
    assert not sender.look()
    assert sender.has("a")


def test_a_host_of_another_swarm_takes_no_agents_away_and_is_named(nodes):
    world, agent = nodes
    refused: list[str] = []
    sender = PerceptSender(world, ("a", "b"))
    sender.join(lambda *_: None, SwarmSettings("pond-1"), refused.append)
    listening = [
        agent.create_subscription(msg.PerceptBatch, f"/{host}/percepts", lambda _: None, qos.CYCLE)
        for host in HOSTS
    ]
    rosters = agent.create_publisher(msg.HostRoster, "/hosts", qos.LATCHED)
    executor = EventsExecutor(context=world.context)
    executor.add_node(world)

    def announce(host: str, number: int, swarm: str) -> None:
        rosters.publish(msg.HostRoster(host=host, number=number, agents=["a"], swarm=swarm))

    announce("ours", 1, "pond-1")
    spin_until(executor, lambda: sender.look() or sender.has("a"))
    for host, swarm in zip(HOSTS, ("pond-2", "pond-2", ""), strict=True):
        announce(host, 2, swarm)
    spin_until(executor, lambda: len(refused) == len(listening))
    assert all(f"host {host}, which lists a:" in refused[i] for i, host in enumerate(HOSTS))
    assert "it is of the swarm pond-2, not of pond-1; end it, or" in refused[0]
    assert "it is of no swarm, not of pond-1" in refused[2]
    assert sender.has("a")
    executor.shutdown()


@pytest.mark.parametrize("agents", [20, 100])
def test_a_look_asks_the_ros_graph_once_however_many_agents_there_are(nodes, monkeypatch, agents):
    world, agent = nodes
    sender = PerceptSender(world, ("a", *(f"ant_{i}" for i in range(agents - 1))))
    asked: list[str] = []

    def noted(name: str, query: Any, *arguments: Any) -> Any:
        asked.append(name)
        return query(*arguments)

    for name in dir(world):
        if name.startswith(GRAPH_QUERIES):
            monkeypatch.setattr(world, name, partial(noted, name, getattr(world, name)))
    assert not sender.look()
    assert len(asked) == 1
    percept_reader(agent)
    wait_until(lambda: sender.look() or sender.has("a"))
    wait_until(lambda: sender.has("a") and not sender.look())
    asked.clear()
    sender.look()
    assert len(asked) == 1
