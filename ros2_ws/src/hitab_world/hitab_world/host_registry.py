"""Percepts to hosts of many agents, and their actions back: one message per host and cycle."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from hitab_msgs import msg
from rclpy.qos import QoSProfile

from hitab_ros import GuardedNode, names, qos
from hitab_world.lockstep import Answer

PerceptOf = Callable[[str], tuple[Sequence[float], Sequence[str]] | None]
"""Returns what an agent perceives; None: send it nothing."""

GONE_MAX = 50  # hosts that are kept although they do not listen, or not yet
HOSTS_MAX = 1000  # announcements that are kept for a late reader
TAKE_IN = QoSProfile(
    depth=HOSTS_MAX, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
)


class _Host:
    """A host, as its last announcement describes it."""

    def __init__(self, node: GuardedNode, roster: msg.HostRoster, known: Iterable[str]) -> None:
        self.number = roster.number
        self.names = tuple(roster.agents)
        places = set(known)
        self.indices = array("I", (i for i, name in enumerate(self.names) if name in places))
        topic = names.in_swarm(node, roster.host, names.PERCEPTS)
        self.publisher = node.create_publisher(msg.PerceptBatch, topic, qos.CYCLE, temporary=True)
        self.percepts = msg.PerceptBatch(roster=roster.number, agents=self.indices)

    @property
    def listens(self) -> bool:
        """Whether the host is present."""
        return bool(self.publisher.get_subscription_count())


class HostRegistry:
    """Knows the hosts that have announced themselves, and which agents they run."""

    def __init__(
        self, node: GuardedNode, agents: Iterable[str], take: Callable[[str, int, Answer], None]
    ) -> None:
        """Subscribe to announcements and actions.

        Args:
            node: of the world.
            agents: all agents of the world.
            take: receives each agent's answer, with the sequence of the percept.
        """
        self._node = node
        self._agents = tuple(agents)
        self._places = frozenset(self._agents)
        self._take = take
        self._hosts: dict[str, _Host] = {}
        self._there: set[str] = set()
        self._listening: set[tuple[str, int]] = set()  # names and numbers of hosts
        self._rosters = node.create_subscription(
            msg.HostRoster, names.in_swarm(node, names.HOSTS), self._on_roster, TAKE_IN
        )
        self._actions = node.create_subscription(
            msg.ActionBatch, names.ACTION_BATCHES, self._on_actions, qos.CYCLE
        )

    def _on_roster(self, roster: msg.HostRoster) -> None:
        if self._places.isdisjoint(roster.agents):
            return  # none of them is an agent of this world
        before = self._hosts.get(roster.host)
        if before is not None:
            if roster.number <= before.number:
                return
            self._forget(roster.host)
        gone = [name for name, host in self._hosts.items() if not host.listens]
        if len(gone) >= GONE_MAX:  # the one that announced itself first
            self._forget(gone[0])
        self._hosts[roster.host] = _Host(self._node, roster, self._agents)

    def _forget(self, name: str) -> None:
        self._node.destroy_publisher(self._hosts.pop(name).publisher)

    def look(self) -> bool:
        """Update which hosts are present; return whether that has changed."""
        listening = {(name, host.number) for name, host in self._hosts.items() if host.listens}
        changed = listening != self._listening
        self._listening = listening
        self._there = {
            host.names[i] for host in self._hosts.values() if host.listens for i in host.indices
        }
        return changed

    def has(self, agent: str) -> bool:
        """Whether a host that was present at the last `look` runs an agent."""
        return agent in self._there

    def send(self, common: dict[str, Any], percept_of: PerceptOf) -> None:
        """Send all hosts their percepts.

        Args:
            common: the fields that all percepts of a cycle share.
            percept_of: returns what an agent perceives; None: send it nothing.
        """
        for name, host in self._hosts.items():
            if host.listens:
                self._node.guard.run(f"percepts to {name}", _send_to, host, common, percept_of)

    def _on_actions(self, batch: msg.ActionBatch) -> None:
        host = self._hosts.get(batch.host)
        if host is None or host.number != batch.roster:
            return
        said = dict(zip(batch.speakers, batch.said, strict=False))
        values, end = batch.values, 0
        for index, count in zip(batch.agents, batch.value_counts, strict=False):
            begin, end = end, end + count
            if index < len(host.names):
                answer = values[begin:end], said.get(index, "")
                self._take(host.names[index], batch.sequence, answer)


def _send_to(host: _Host, common: dict[str, Any], percept_of: PerceptOf) -> None:
    batch = host.percepts
    for name, value in common.items():
        setattr(batch, name, value)
    agents, values, value_counts = host.indices, array("d"), array("I")
    heard_counts = array("I")
    heard: list[str] = []
    for index in host.indices:
        sensed = percept_of(host.names[index])
        if sensed is None:
            agents = array("I", (i for i in agents if i != index))
            continue
        seen, said = sensed
        values.extend(seen)
        value_counts.append(len(seen))
        heard_counts.append(len(said))
        heard += said
    batch.agents = agents
    batch.values = values
    batch.value_counts = value_counts
    batch.heard = heard
    batch.heard_counts = heard_counts if heard else array("I")
    host.publisher.publish(batch)
