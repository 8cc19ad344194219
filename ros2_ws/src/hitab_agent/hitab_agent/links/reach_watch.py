"""Watches who is in reach of a process: the commanders and the operator of agents that halt."""

from __future__ import annotations

import time

from hitab_msgs import msg

from hitab_agent.links.order_exchange import Exchange
from hitab_agent.node.agent_base import AgentBase
from hitab_agent.process_signs import ProcessSigns
from hitab_agent.scheduler import Scheduler
from hitab_ros import GuardedNode, HostRosters, ListenedTime, names, qos
from hitab_ros.timing import HEARTBEAT_S

OPERATOR = "the operator"


class Reach:
    """Who must be in reach of agents, which halt otherwise; equal agents share it.

    Attributes:
        why: who is out of reach, and since when; empty if nobody is.
    """

    def __init__(self) -> None:
        self.why = ""
        self.nodes: list[AgentBase] = []

    def set(self, why: str) -> None:
        """Set who is out of reach, and show it in the status of each agent."""
        if why == self.why:
            return
        self.why = why
        for node in self.nodes:
            if node.stop is None:  # otherwise the robot's stop shows it as its cause
                node.guard.faults.set("reach", why)


class ReachWatch:
    """Listens for signs of life of commanders and of people's consoles, once for a process.

    A commander in the same process is always in reach. A commander or console that was never heard
    does not count as lost.
    """

    def __init__(
        self,
        node: GuardedNode,
        exchange: Exchange,
        signs: ProcessSigns,
        scheduler: Scheduler,
        rosters: HostRosters | None,
    ) -> None:
        """Create no endpoints yet.

        Args:
            node: the node of the only agent, or of a host, in its own namespace.
            exchange: the process's exchange, which knows the commanders in the process.
            signs: the process's signs of life, and those of others.
            scheduler: the process's scheduler.
            rosters: the rosters of all hosts; None if the process is no host.
        """
        self._node, self._exchange, self._signs = node, exchange, signs
        self._scheduler, self._rosters = scheduler, rosters
        self._reaches: dict[tuple[tuple[str, ...], float], Reach] = {}
        self._watched: set[str] = set()
        self._time = ListenedTime(HEARTBEAT_S)
        self._heard: dict[str, tuple[float, float]] = {}  # s of listening, and of the wall clock

    def join(self, node: AgentBase) -> Reach:
        """Watch who must be in reach of an agent."""
        settings = node.settings
        needed = tuple(filter(None, (settings.commander, *settings.superiors))) or (OPERATOR,)
        if not self._reaches:
            self._scheduler.every(HEARTBEAT_S, self._look)
        if settings.commander and not self._watched - {OPERATOR}:
            hosts = names.in_swarm(self._node, names.HOSTS)
            self._rosters = self._rosters or HostRosters(self._node, hosts)
            self._signs.follow_all(self._hear)
        elif not settings.commander and OPERATOR not in self._watched:
            operators = names.in_swarm(self._node, names.OPERATORS)
            self._node.create_subscription(
                msg.Alive, operators, lambda sign: self._note(OPERATOR), qos.SIGNS_OF_LIFE
            )
        self._watched.update(needed)
        reach = self._reaches.setdefault((needed, settings.out_of_reach_after), Reach())
        reach.nodes.append(node)
        return reach

    def _hear(self, sign: msg.Alive) -> None:
        assert self._rosters is not None, "who listens has rosters"
        for name in self._watched:
            if sign.process in self._rosters.hosts_of.get(name, (name,)):
                self._note(name)

    def _note(self, name: str) -> None:
        self._heard[name] = self._time.now(), time.time()

    def _look(self) -> None:
        now = self._time.now()
        for (needed, after), reach in self._reaches.items():
            lost = (
                (name, self._heard[name][1])
                for name in needed
                if name in self._heard
                and now - self._heard[name][0] > after
                and not self._exchange.is_here(name)
            )
            name, since = next(lost, ("", 0.0))
            told = time.strftime("%H:%M:%S", time.localtime(since))
            reach.set(f"{name} is out of reach: silent since {told}" if name else "")
