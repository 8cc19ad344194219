"""Watching a swarm takes as many subscriptions and looks at the graph, however large it is."""

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, CommanderStatus, HostStatuses, Subordinate

from hitab_client import CommanderView, RosLink, SwarmClient, domain_ids
from hitab_client.runs.run_processes import RunProcesses
from hitab_ros import names, qos

BATCH = 100
IDENTITY = "many-0a1b2c3d"
GRAPH_QUERIES = (
    "get_topic_names_and_types",
    "get_publishers_info_by_topic",
    "count_publishers",
    "count_subscribers",
)


class Hosts:
    """A stand-in for hosts, which report all of their agents and commanders in batches.

    Attributes:
        agents: the names of the agents and commanders.
        commanders: the names of the commanders, of ten agents each.
    """

    def __init__(self, link: RosLink, count: int) -> None:
        self.agents = [f"agent_{number}" for number in range(count)]
        self.commanders = self.agents[::10]
        self._publisher = link.node.create_publisher(
            HostStatuses, names.of_swarm(names.STATUSES), qos.STATUSES
        )

    def publish(self, sequence: int = 1, **fields: Any) -> None:
        """Report everybody."""
        for start in range(0, len(self.agents), BATCH):
            members = self.agents[start : start + BATCH]
            statuses = [
                AgentStatus(agent=name, swarm=IDENTITY, process=1, sequence=sequence, **fields)
                for name in members
            ]
            groups = [
                CommanderStatus(
                    commander=name,
                    swarm=IDENTITY,
                    subordinates=[Subordinate(name=name, silent=sequence == 1)] * 10,
                )
                for name in members
                if name in self.commanders
            ]
            self._publisher.publish(HostStatuses(host="h", agents=statuses, groups=groups))


@contextmanager
def watched(count: int) -> Iterator[tuple[Hosts, RosLink, Counter[str], RunProcesses]]:
    """Yield a stand-in for hosts, a link, the counted calls of its node, and the processes."""
    with domain_ids.reserved() as number, RosLink(number) as far, RosLink(number) as link:
        hosts = Hosts(far, count)
        counted: Counter[str] = Counter()
        for name in ("create_subscription", *GRAPH_QUERIES):
            setattr(link.node, name, _counting(counted, name, getattr(link.node, name)))
        record: Any = SimpleNamespace(
            processes={"host_1": tuple(hosts.agents)}, world=False, machines={}
        )
        processes = RunProcesses(record)
        processes._ask = lambda: None  # type: ignore[method-assign]
        yield hosts, link, counted, processes


def _counting(counted: Counter[str], name: str, call: Any) -> Any:
    def called(*args: Any, **more: Any) -> Any:
        counted[name] += 1
        return call(*args, **more)

    return called


@pytest.mark.parametrize("count", [200, 10_000])
def test_watching_all_takes_one_subscription_and_one_look(count: int):
    with watched(count) as (hosts, link, counted, processes):
        agents = SwarmClient(link, hosts.agents, identity=IDENTITY, processes=processes)
        view = CommanderView(agents)
        counted.clear()
        agents.watch_all()
        view.watch(hosts.commanders if count > 1000 else ())
        assert link.spin_until(lambda: hosts._publisher.get_subscription_count() == 1, 10.0)
        hosts.publish()
        assert link.spin_until(lambda: not agents.unheard, 60.0)
        assert counted == {"create_subscription": 1}
        agents.discover()
        view.discover()
        assert counted == {"create_subscription": 1, "get_topic_names_and_types": 2}
        assert view.groups.keys() == set(hosts.commanders)
        assert len(view.incomplete) == (len(hosts.commanders) if count > 1000 else 0)
        hosts.publish(2, faults=["cold"])
        last = hosts.agents[-1]
        assert link.spin_until(lambda: agents.statuses[last].sequence == 2, 60.0)
        assert agents.faulty.keys() == set(hosts.agents)
        assert not view.incomplete


def test_one_agent_of_many_is_watched_alone_and_agents_without_a_host_on_their_own_topics():
    with watched(200) as (hosts, link, counted, processes):
        with RosLink(link.node.context.get_domain_id()) as robot:
            topic = names.of_agent("robot", names.STATUS)
            publisher = robot.node.create_publisher(AgentStatus, topic, qos.LATCHED)
            publisher.publish(AgentStatus(agent="robot", swarm=IDENTITY))
            started = [*hosts.agents, "robot"]
            agents = SwarmClient(link, started, identity=IDENTITY, processes=processes)
            counted.clear()
            assert agents.await_agent("robot").agent == "robot"
            assert counted["create_subscription"] == 1
            assert not hosts._publisher.get_subscription_count()
        agents.watch_all()
        assert counted["create_subscription"] == 2
        assert agents.agents() == ["robot"]


def test_an_older_status_from_a_host_is_not_taken():
    with watched(200) as (hosts, link, _, processes):
        agents = SwarmClient(link, hosts.agents, identity=IDENTITY, processes=processes)
        agents.watch_all()
        assert link.spin_until(lambda: hosts._publisher.get_subscription_count() == 1, 10.0)
        for sequence, faults in ((5, []), (4, ["old"]), (6, [])):
            hosts.publish(sequence, faults=faults)
        assert link.spin_until(
            lambda: all(s.sequence == 6 for s in agents.statuses.values()) and agents.statuses,
            20.0,
        )
        assert not agents.faulty


def test_a_host_of_another_swarm_makes_its_agents_strangers():
    with watched(200) as (hosts, link, _, processes):
        agents = SwarmClient(link, hosts.agents, identity="other-11111111", processes=processes)
        agents.watch_all()
        assert link.spin_until(lambda: hosts._publisher.get_subscription_count() == 1, 10.0)
        hosts.publish()
        assert link.spin_until(lambda: len(agents.strangers) == 200, 20.0)
        assert not agents.statuses


def test_many_agents_that_were_started_by_hand_are_watched_on_request_as_well():
    with watched(200) as (hosts, link, _, processes):
        agents = SwarmClient(link, identity=IDENTITY, processes=processes)
        assert not agents.is_large
        agents.watch_all()
        assert link.spin_until(lambda: hosts._publisher.get_subscription_count() == 1, 10.0)
        hosts.publish()
        assert link.spin_until(lambda: len(agents.statuses) == 200, 60.0)
        assert agents.is_large
