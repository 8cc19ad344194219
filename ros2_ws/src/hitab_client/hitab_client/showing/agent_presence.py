"""Presence of agents: waits for agents, and reports why an agent does not answer."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence

from hitab_msgs.msg import AgentStatus, CommanderStatus, HostStatuses

from hitab_client.connecting.identity import is_own
from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_client.runs.run_processes import RunProcesses
from hitab_client.showing.swarm_listener import SwarmListener
from hitab_core import Fix, has, some
from hitab_ros import SignsOfLife, check_same_message_version, names, qos, steady_timer
from hitab_ros.call import blocking
from hitab_ros.messages.checks import ROS_NAME
from hitab_ros.timing import DISCOVERY_EACH_S, DISCOVERY_S, FOUND_S, LOOK_EACH_S, POLL_S, SETTLE_S

WATCHED_MAX = 100
"""Maximum number of agents that are watched one by one, from the start; others on request."""


def is_older(status: AgentStatus, known: AgentStatus) -> bool:
    """Return whether a status is older than a known one, as it may be beside an answer."""
    return status.process == known.process and status.sequence < known.sequence


class AgentPresence(SwarmListener):
    """The agents of a swarm that have reported.

    Args:
        link: the node to use.
        expected: names of the expected agents, if known.
        prefix: namespace of the swarm.
        identity: the swarm's identity; empty for any swarm.
        processes: the swarm's processes, which show why an agent does not answer.

    Attributes:
        expected: names of the expected agents.
        statuses: the last status of each agent of the swarm, by name.
        unheard: the expected agents that have not reported, in order.
        faulty: the agents with faults.
        news: the agents that have reported since an observer cleared it.
    """

    def __init__(
        self,
        link: RosLink,
        expected: Iterable[str] = (),
        *,
        prefix: str = "",
        identity: str = "",
        processes: RunProcesses | None = None,
    ) -> None:
        self.expected = dict.fromkeys(expected)
        super().__init__(link, prefix, identity, self.expected)
        self.unheard = self.expected.copy()
        self.processes = processes or RunProcesses()
        self.statuses: dict[str, AgentStatus] = {}
        self.faulty: dict[str, None] = {}
        self.news: set[str] = set()
        self._watched: set[str] = set()
        self._hosts: dict[str, str] = {}  # by agent or commander
        self._signs: SignsOfLife | None = None
        self._groups: dict[str, CommanderStatus] = {}
        self._group_takers: list[Callable[[CommanderStatus], None]] = []
        self._hears_hosts = False
        self._begin_waiting()
        if not self.is_large:
            for agent in self.expected:
                self._watch(agent)

    def watch_all(self) -> None:
        """Watch all agents: those in hosts on one topic, the expected others on their own."""
        self._hear_hosts()
        for agent in self.expected:
            if not self.is_hosted(agent):
                self._watch(agent)

    def hear_groups(self, take: Callable[[CommanderStatus], None]) -> None:
        """Call a function with each report of a commander in a host from now on."""
        self._hear_hosts()
        self._group_takers.append(take)
        for group in self._groups.values():
            take(group)

    def is_hosted(self, name: str) -> bool:
        """Whether an agent or commander is known to run in a host with others."""
        return name in self._hosts or self.processes.is_hosted(name)

    def host_of(self, name: str) -> str:
        """Return the name of the host of an agent or commander, which the first agent names.

        It is empty if the host has not been heard, and may be on any machine.
        """
        return self._hosts.get(name, "" if self.processes.have_leases else names.of_host(name))

    def _hear_hosts(self) -> None:
        if not self._hears_hosts:
            self._hears_hosts = True
            topic = names.of_swarm(names.STATUSES, self.prefix)
            # Without the history, since each host sends everything to a new subscriber.
            self.link.subscribe(HostStatuses, topic, self._take_batch, qos.ROLL_CALL)

    def _take_batch(self, batch: HostStatuses) -> None:
        for status in batch.agents:
            if ROS_NAME.match(status.agent) is not None:
                self._hosts[status.agent] = batch.host
                self._take_status(status.agent, status)
        for group in batch.groups:
            if ROS_NAME.match(group.commander) is not None:
                self._groups[group.commander] = group
                for take in self._group_takers:
                    take(group)

    def _watch(self, agent: str) -> None:
        if agent not in self._watched:
            self._watched.add(agent)
            self.link.subscribe(
                AgentStatus,
                names.of_agent(agent, names.STATUS, self.prefix),
                lambda status: self._take_status(agent, status),
                qos.LATCHED,
            )

    def _take_status(self, agent: str, status: AgentStatus) -> None:
        if self._is_own(agent, status.swarm):
            if agent not in self.statuses:
                self._newest_at = time.monotonic()
                self.unheard.pop(agent, None)
            known = self.statuses.get(agent)
            if known is None or not is_older(status, known):
                self.statuses[agent] = status
                self.news.add(agent)
                if status.faults:
                    self.faulty[agent] = None
                else:
                    self.faulty.pop(agent, None)
        else:
            self.statuses.pop(agent, None)
            self.faulty.pop(agent, None)

    def signs_of_life(self, *, has_world: bool = False) -> SignsOfLife:
        """Listen for signs of life of the swarm's processes from now on.

        Args:
            has_world: whether the swarm has started a world.
        """
        started = {*self.expected, *([names.WORLD] if has_world else [])}
        return SignsOfLife(
            self.link.node,
            self.prefix,
            lambda name, owner: is_own(owner, self.identity, started_by_it=name in started),
            leases=self.processes.have_leases,
        )

    def is_lost(self, name: str) -> bool:
        """Whether waiting for an agent or the world is useless.

        Its process must show the reason, and no process may give a sign of life for it: the agent
        may run elsewhere.
        """
        return self.processes.is_lost(name) and self._heard().misses(name)

    def reason(self, name: str) -> SwarmError | None:
        """Return an error for a silent agent; None if its process shows no reason, or it lives."""
        lives = self._signs is not None and not self._signs.misses(name)
        return None if lives and name in self._heard().last_signs else self.processes.reason(name)

    @blocking
    async def lost_of(self, among: Iterable[str]) -> set[str]:
        """Return those agents, or the world, for which waiting is useless, once this is known."""
        suspects = {name for name in among if self.processes.is_lost(name)}
        if suspects:
            signs = self._heard()
            unknown = {*suspects}

            def known() -> bool:
                decided = {n for n in unknown if n in signs.last_signs or signs.misses(n)}
                unknown.difference_update(decided)
                return not unknown

            await self.link.until(known, FOUND_S)
        return {name for name in suspects if self.is_lost(name)}

    def _heard(self) -> SignsOfLife:
        """Return the signs of life heard since they were first asked for."""
        if self._signs is None:
            self._signs = self.signs_of_life(has_world=names.WORLD in self.processes)
            steady_timer(self.link.node, POLL_S, self._signs.listen)
        return self._signs

    def discover(self) -> None:
        """Look for new agents, in hosts and elsewhere."""
        self._hear_hosts()
        for topic in self.link.topics_of_type(names.STATUS_TYPE):
            agent = names.agent_of_status(topic, self.prefix)
            if agent is not None and not self.is_hosted(agent):
                self._watch(agent)

    def gone(self) -> list[str]:
        """Return the agents that have left the graph, of those with topics of their own."""
        publishers = self.link.node.count_publishers
        alone = (a for a in self._watched if not (self.is_large and self.is_hosted(a)))
        topics = {a: names.of_agent(a, names.STATUS, self.prefix) for a in alone}
        return [a for a, topic in topics.items() if a in self.statuses and not publishers(topic)]

    def agents(self) -> list[str]:
        """Return the names of the agents that have reported so far."""
        return sorted(self.statuses)

    def mates_of(self, agent: str) -> list[str]:
        """Return the names of the other agents of an agent's domain that have reported so far."""
        domain = self.statuses[agent].domain
        return [a for a in self.agents() if a != agent and self.statuses[a].domain == domain]

    @blocking
    async def await_agents(
        self, agents: Sequence[str] = (), seconds: float = DISCOVERY_S
    ) -> list[str]:
        """Wait for these agents, by default for the expected ones; return the agents that are up.

        Agents whose processes have ended are not waited for. Without expected agents, wait until
        no new agent has appeared for a while.

        Raises:
            SwarmError: if one of them belongs to another swarm.
        """
        wanted = {*agents} or self.expected.keys()
        few = 0 < len(agents) <= WATCHED_MAX
        if few:
            for agent in wanted:
                self._watch(agent)
        else:
            self.watch_all()
        self._begin_waiting()
        lost: set[str] = set()
        waiting = sorted(wanted, reverse=True)

        def complete() -> bool:
            if self._is_due():
                lost.clear()
                lost.update(filter(self.is_lost, self.processes.lost()))
                if not (few and self.is_large):
                    self.discover()
            if wanted:
                self.refuse_strangers(wanted)
                while waiting and (waiting[-1] in self.statuses or waiting[-1] in lost):
                    waiting.pop()
                return not waiting
            return bool(self.statuses) and self._is_settled

        await self.link.until(
            complete,
            seconds + self.more_seconds,
            waiting_for=lambda: some(sorted(self._awaited(wanted))) or "agents to appear",
        )
        check_same_message_version(self.link.node)
        return self.agents()

    @blocking
    async def await_agent(self, agent: str, seconds: float = DISCOVERY_S) -> AgentStatus:
        """Wait for an agent and return its status.

        Raises:
            SwarmError: if the agent does not answer (with the reason, if known), does not exist
                (with the existing agents), or belongs to another swarm.
        """
        self.refuse_strangers((agent,))
        if agent not in self.statuses:
            self._watch(agent)
            if agent in self.expected:
                await self.await_agents.coroutine((agent,), seconds)
            else:
                await self._await_unexpected(agent, seconds)
            self.refuse_strangers((agent,))
        if agent not in self.statuses:
            raise self._absence(agent, seconds)
        return self.statuses[agent]

    async def _await_unexpected(self, agent: str, seconds: float) -> None:
        """Wait for an agent that may have been started by hand, as long as it shows any sign."""
        topic = names.of_agent(agent, names.STATUS, self.prefix)
        self._begin_waiting()

        def decided() -> bool:
            if self._is_due() and not self.is_large:
                self.discover()
            if agent in self.statuses or agent in self.strangers:
                return True
            if self.link.node.count_publishers(topic) or not self._is_settled:
                return False
            return self.is_large or (bool(self.statuses) and not self._awaited(self.expected))

        await self.link.until(decided, seconds, waiting_for=lambda: agent)
        check_same_message_version(self.link.node)

    @property
    def more_seconds(self) -> float:
        """Additional time to wait for a node of the swarm, s."""
        return DISCOVERY_EACH_S * len(self.expected)

    @property
    def is_large(self) -> bool:
        """Whether agents are watched only on request."""
        return len(self.unheard) + len(self.statuses) > WATCHED_MAX

    def _awaited(self, agents: Iterable[str]) -> set[str]:
        """Return the agents, of these, that have not reported and still may."""
        missing = set(agents) - self.statuses.keys()
        return {agent for agent in missing if not self.is_lost(agent)}

    def _begin_waiting(self) -> None:
        self._looks_at, self._newest_at = -math.inf, time.monotonic()

    def _is_due(self) -> bool:
        """Whether topics and processes are due for another check."""
        now = time.monotonic()
        if now < self._looks_at:
            return False
        self._looks_at = now + POLL_S + LOOK_EACH_S * len(self.expected)
        return True

    @property
    def _is_settled(self) -> bool:
        """Whether no new agent has reported for a while."""
        return time.monotonic() > self._newest_at + SETTLE_S

    def _absence(self, agent: str, waited: float) -> SwarmError:
        """Return the error for an agent that did not answer for some seconds."""
        if agent in self.expected or agent in self.statuses:
            if (reason := self.reason(agent)) is not None:
                return reason
            pid = self.processes.pid(agent)
            running = f"; its process ({pid}) still runs" if pid else ""
            silent = f"{agent} has been silent for {round(waited, 1):g} s"
            return SwarmError(f"{silent}{running}", Fix.LOGS(node=agent))
        known = {*self.statuses, *self.expected}
        if not known:
            silent = f'no agent "{agent}" answers, and no other does'
            return SwarmError(silent, Fix.UP(swarm="keepaway"))
        return SwarmError(f'no agent "{agent}" answers {has(known, agent)}', Fix.STATUS())
