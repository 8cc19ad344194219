"""The registry of hosts: it sends them percepts and takes actions, one message per cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from hitab_msgs import msg
from rclpy.qos import QoSProfile

from hitab_core import some
from hitab_ros import GuardedNode, names, qos
from hitab_ros.messages.pieces import PIECE_BYTES, PieceReader, publish_pieces
from hitab_world.node.percept_batches import Sensed, percept_batches
from hitab_world.simulating.lockstep import Answer

PerceptOf = Callable[[str], Sensed | None]
"""A function that returns an agent's percept; None to send nothing."""

HOSTS_MAX = 1000  # how many announcements are kept until this process reads them
ROSTERS_QOS = QoSProfile(
    depth=HOSTS_MAX, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
)


class _Host:
    """A host, as described by its last announcement."""

    def __init__(self, node: GuardedNode, roster: msg.HostRoster, known: frozenset[str]) -> None:
        self.number = roster.number
        self.names = tuple(roster.agents)
        self.indices = [i for i, name in enumerate(self.names) if name in known]
        topic = names.in_swarm(node, roster.host, names.PERCEPTS)
        self.publisher = node.create_publisher(msg.PerceptBatch, topic, qos.CYCLE, temporary=True)
        self.pieces: Any = None
        if roster.machine:
            topic = names.in_swarm(node, roster.host, names.PERCEPT_PIECES)
            self.pieces = node.create_publisher(
                msg.PerceptBatch, topic, qos.PIECES, temporary=True
            )

    @property
    def listens(self) -> bool:
        """Whether the host is present."""
        return bool(self.publisher.get_subscription_count())

    def send(self, common: dict[str, Any], percept_of: PerceptOf) -> None:
        """Send the percepts of the host's agents: in real time to another machine, in pieces."""
        sensed = ((index, percept_of(self.names[index])) for index in self.indices)
        if self.pieces is None or common["lockstep"] or common["look"]:
            for batch in percept_batches(self.number, common, sensed):
                self.publisher.publish(batch)
        else:
            pieces = percept_batches(self.number, common, sensed, PIECE_BYTES)
            publish_pieces(self.pieces, pieces)


class HostRegistry:
    """Knows the hosts that have announced themselves, and which agents they run."""

    def __init__(
        self,
        node: GuardedNode,
        agents: Iterable[str],
        take: Callable[[str, int, Answer], None],
        swarm: str = "",
        report: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Subscribe to announcements and actions.

        Args:
            node: the world's node.
            agents: all agents of the world.
            take: receives each agent's answer, with the sequence of the percept.
            swarm: identity of the swarm whose hosts are accepted; empty to accept all.
            report: called with the reason why a host is refused.
        """
        self._node, self._agents, self._take = node, frozenset(agents), take
        self._swarm, self._report = swarm, report
        self._hosts: dict[str, _Host] = {}
        self._hosted: set[str] = set()
        self._hears_pieces = False
        self._listening: set[tuple[str, int]] = set()  # names and numbers of hosts
        rosters = names.in_swarm(node, names.HOSTS)
        node.create_subscription(msg.HostRoster, rosters, self._on_roster, ROSTERS_QOS)
        node.create_subscription(
            msg.ActionBatch, names.ACTION_BATCHES, self._on_actions, qos.CYCLE
        )

    def _on_roster(self, roster: msg.HostRoster) -> None:
        if self._agents.isdisjoint(roster.agents):
            return  # the host runs no agent of this world
        if self._swarm and roster.swarm != self._swarm:
            self._report(
                f"refused the host {roster.host}, which lists {some(roster.agents)}: it is of "
                f"{f'the swarm {roster.swarm}' if roster.swarm else 'no swarm'}, not of "
                f"{self._swarm}; end it, or start it with -p swarm:={self._swarm}"
            )
            return
        before = self._hosts.get(roster.host)
        if before is not None:
            if roster.number <= before.number:
                return
            self._node.destroy_publisher(before.publisher)
            if before.pieces is not None:
                self._node.destroy_publisher(before.pieces)
        if roster.machine and not self._hears_pieces:
            self._hears_pieces = True
            self._node.create_subscription(
                msg.ActionBatch,
                names.ACTION_PIECES,
                self._on_actions,
                qos.PIECES,
                read=PieceReader(msg.ActionBatch),
            )
        self._hosts[roster.host] = _Host(self._node, roster, self._agents)

    def look(self) -> bool:
        """Update which hosts are present; return whether that has changed."""
        there = {name: host for name, host in self._hosts.items() if host.listens}
        before = self._listening
        self._listening = {(name, host.number) for name, host in there.items()}
        self._hosted = {host.names[i] for host in there.values() for i in host.indices}
        return before != self._listening

    @property
    def present(self) -> int:
        """How many hosts were present at the last `look`."""
        return len(self._listening)

    def has(self, agent: str) -> bool:
        """Return whether an agent runs in a host that was present at the last `look`."""
        return agent in self._hosted

    def send(self, common: dict[str, Any], percept_of: PerceptOf) -> None:
        """Send all hosts their percepts.

        Args:
            common: the fields that all percepts of a cycle share.
            percept_of: returns an agent's percept; None to send nothing.
        """
        for name, host in self._hosts.items():
            if host.listens:
                self._node.guard.run(f"percepts to {name}", host.send, common, percept_of)

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
