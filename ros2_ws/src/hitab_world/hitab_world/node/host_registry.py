"""The registry of hosts: it sends them percepts and takes actions, one message per cycle."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from hitab_msgs import msg
from rclpy.qos import QoSProfile

from hitab_core import some
from hitab_ros import GuardedNode, names, qos
from hitab_ros.leases import is_later, rank
from hitab_ros.messages.pieces import PIECE_BYTES, PieceReader, publish_pieces
from hitab_world.node.percept_batches import Sensed, percept_batches
from hitab_world.simulating.lockstep import Take


@dataclass(frozen=True)
class SwarmSettings:
    """The swarm whose hosts a world accepts.

    Attributes:
        identity: identity of the swarm; empty to accept those of any.
        machines: the machines of the swarm; empty if it is on one.
    """

    identity: str = ""
    machines: Sequence[str] = ()

    def why_foreign(self, roster: msg.HostRoster) -> str:
        """Return why a roster is not of the swarm, and the way out; empty if it is."""
        own, other, machine = self.identity, roster.swarm, roster.machine
        if own and other != own:
            of = f"the swarm {other}" if other else "no swarm"
            return f"it is of {of}, not of {own}; end it, or start it with -p swarm:={own}"
        of = f"the machine {machine}" if machine else "no machine"
        if not self.machines and (machine or roster.lease):
            return (
                f"it has the lease {roster.lease} of {of}, and this "
                "world's swarm has no machines; end it, or start it without -p machine, -p lease"
            )
        if self.machines and machine not in self.machines:
            return (
                f"it is of {of}, not of {some(self.machines)}; end it, or start it with the name "
                "of one as -p machine"
            )
        return ""


ANY_SWARM = SwarmSettings()

PerceptOf = Callable[[str], Sensed | None]
"""A function that returns an agent's percept; None to send nothing."""

HOSTS_MAX = 1000  # how many announcements are kept until this process reads them
ROSTERS_QOS = QoSProfile(
    depth=HOSTS_MAX, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
)


class _Host:
    """A host, as described by its last announcement.

    Attributes:
        roster: the announcement.
        answered: whether the host has answered percepts.
        listens: whether the host was present at the last `look`.
        indices: places of the agents that it holds in its roster.
    """

    def __init__(self, node: GuardedNode, roster: msg.HostRoster, *, answered: bool) -> None:
        self.roster, self.answered, self.listens = roster, answered, False
        self.indices: list[int] = []
        topic = names.in_swarm(node, roster.host, names.PERCEPTS)
        self.publisher = node.create_publisher(msg.PerceptBatch, topic, qos.CYCLE, temporary=True)
        self.pieces: Any = None
        if roster.machine:
            topic = names.in_swarm(node, roster.host, names.PERCEPT_PIECES)
            self.pieces = node.create_publisher(
                msg.PerceptBatch, topic, qos.PIECES, temporary=True
            )

    def look(self) -> tuple[str, int, bool, bool]:
        """Update whether the host is present; return what decides whether it holds agents."""
        self.listens = bool(self.publisher.get_subscription_count())
        return self.roster.host, self.roster.number, self.listens, self.answered

    def send(self, common: dict[str, Any], percept_of: PerceptOf) -> None:
        """Send the percepts of the host's agents: in real time to another machine, in pieces."""
        sensed = ((index, percept_of(self.roster.agents[index])) for index in self.indices)
        if self.pieces is None or common["lockstep"] or common["look"]:
            for batch in percept_batches(self.roster.number, common, sensed):
                self.publisher.publish(batch)
        else:
            pieces = percept_batches(self.roster.number, common, sensed, PIECE_BYTES)
            publish_pieces(self.pieces, pieces)


class HostRegistry:
    """Knows the hosts that have announced themselves, and which agents each holds.

    Only hosts that listen hold agents. Of those with leases, the one with precedence holds an
    agent, see `hitab_ros.leases`. Without, an agent that has a process of its own is in no host,
    and a host keeps its agents for as long as it listens. Who claims the agent of another one is
    refused, as a fault.
    """

    def __init__(
        self,
        node: GuardedNode,
        agents: Iterable[str],
        take: Take,
        settings: SwarmSettings = ANY_SWARM,
        report: Callable[[str], None] = lambda text: None,
    ) -> None:
        """Subscribe to announcements and actions.

        Args:
            node: the world's node.
            agents: all agents of the world.
            take: receives each agent's answer, with the sequence of the percept.
            settings: the swarm whose hosts are accepted.
            report: called with the reason why a host is refused.
        """
        self._node, self._agents, self._take = node, frozenset(agents), take
        self._settings, self._report = settings, report
        self._hosts: dict[str, _Host] = {}
        self._holders: dict[str, _Host] = {}
        self._alone: Collection[str] = ()
        self._seen: Any = None  # what the last `look` saw
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
        if why := self._settings.why_foreign(roster):
            self._report(
                f"refused the host {roster.host}, which lists {some(roster.agents)}: {why}"
            )
            return
        before = self._hosts.get(roster.host)
        if before is not None:
            if not is_later(roster, before.roster):
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
        answered = before is not None and before.answered
        self._hosts[roster.host] = _Host(self._node, roster, answered=answered)
        self._share_out()

    def look(self, alone: Collection[str] = ()) -> bool:
        """Update which hosts are present; return whether that has changed.

        Args:
            alone: the agents that answer in processes of their own.
        """
        seen = {*alone}, [host.look() for host in self._hosts.values()]
        if seen != self._seen:  # else it would cost more with each agent of the world
            self._seen, self._alone = seen, alone
            self._share_out()
        before = self._listening
        self._listening = {
            (name, host.roster.number)
            for name, host in self._hosts.items()
            if host.indices and host.listens
        }
        return before != self._listening

    def _share_out(self) -> None:
        """Decide which host holds each agent, and show the refused ones."""
        claims: dict[str, list[_Host]] = {}
        for host in self._hosts.values():
            for name in self._agents.intersection(host.roster.agents):
                claims.setdefault(name, []).append(host)
        found = {name: self._holder(name, hosts) for name, hosts in claims.items()}
        self._holders = {name: host for name, host in found.items() if host is not None}
        for name, host in self._hosts.items():
            agents = host.roster.agents
            host.indices = [i for i, a in enumerate(agents) if self._holders.get(a) is host]
            self._node.guard.faults.set(f"roster of {name}", self._why_refused(host))

    def _holder(self, name: str, hosts: list[_Host]) -> _Host | None:
        hosts = [host for host in hosts if host.listens]
        first = min(hosts, key=lambda host: rank(host.roster), default=None)
        if first is None or first.roster.lease:
            return first
        if name in self._alone:
            return None
        before = self._holders.get(name)
        keeps = None if before is None else before.roster.host

        def order(host: _Host) -> tuple[bool, int]:
            # Before it has answered, the first that was started, whichever was heard first.
            return not (host.answered and host.roster.host == keeps), host.roster.number

        return min(hosts, key=order)

    def _why_refused(self, host: _Host) -> str:
        """Return why a host that listens does not hold all of its agents; empty if it does."""
        held = {host.roster.agents[i] for i in host.indices}
        lost: dict[_Host | None, list[str]] = {}
        for name in sorted(self._agents.intersection(host.roster.agents) - held):
            lost.setdefault(self._holders.get(name), []).append(name)
        if not lost or not host.listens:
            return ""
        return "; ".join(_refused(host.roster, names, by) for by, names in lost.items())

    @property
    def present(self) -> int:
        """How many hosts that hold agents were present at the last `look`."""
        return len(self._listening)

    def has(self, agent: str) -> bool:
        """Return whether an agent is held by a host that was present at the last `look`."""
        holder = self._holders.get(agent)
        return holder is not None and (
            (holder.roster.host, holder.roster.number) in self._listening
        )

    def send(self, common: dict[str, Any], percept_of: PerceptOf) -> None:
        """Send all hosts their percepts.

        Args:
            common: the fields that all percepts of a cycle share.
            percept_of: returns an agent's percept; None to send nothing.
        """
        for name, host in self._hosts.items():
            if host.indices and host.listens:
                self._node.guard.run(f"percepts to {name}", host.send, common, percept_of)

    def _on_actions(self, batch: msg.ActionBatch) -> None:
        host = self._hosts.get(batch.host)
        if host is None or host.roster.number != batch.roster:
            return
        host.answered |= bool(host.indices)
        agents = host.roster.agents
        said = dict(zip(batch.speakers, batch.said, strict=False))
        holds = dict(zip(batch.holders, batch.holds, strict=False))
        taught = frozenset(batch.taught)
        values, end = batch.values, 0
        for index, count in zip(batch.agents, batch.value_counts, strict=False):
            begin, end = end, end + count
            if index < len(agents) and self._holders.get(agents[index]) is host:
                answer = values[begin:end], said.get(index, "")
                self._take(
                    agents[index],
                    batch.sequence,
                    answer,
                    taught=index in taught,
                    hold=holds.get(index, ""),
                )


def _refused(roster: msg.HostRoster, agents: Sequence[str], holder: _Host | None) -> str:
    """Return why a host does not get agents, which another one holds or their own processes."""
    lists = f"the host {roster.host} lists {some(agents)}, which"
    if holder is None:
        have = "has a process of its own" if len(agents) == 1 else "have processes of their own"
        return f"{lists} {have}: refused; end {roster.host}"
    other = holder.roster
    if not other.lease:
        return f"{lists} {other.host} runs: refused; end one of the two"
    return (
        f"{lists} {other.host} runs on {other.machine} (lease {other.lease}): refused, since it "
        f"has lease {roster.lease}; it should yield by itself, else end {roster.host}"
    )
