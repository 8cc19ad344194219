"""Watches who is in reach of a process: the commanders and the operator of agents that halt."""

from __future__ import annotations

import time
from typing import Any

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_ros import GuardedNode, HostRosters, ListenedTime, names, qos
from hitab_ros.timing import HEARTBEAT_S

OPERATOR = "the operator"


class ReachWatch:
    """Listens for signs of life of commanders and of people's consoles, once for a process.

    A commander in the same process is always in reach. A commander or console that was never heard
    does not count as lost.
    """

    def __init__(self, node: GuardedNode, shared: Any, rosters: HostRosters | None) -> None:
        """Create no endpoints yet.

        Args:
            node: the node of the only agent, or of a host, in its own namespace.
            shared: the `HostResources` of the process.
            rosters: the rosters of all hosts; None if the process is no host.
        """
        self._node, self._shared, self._rosters = node, shared, rosters
        self._groups: dict[tuple[tuple[str, ...], float], list[AgentBase]] = {}
        self._watched: set[str] = set()
        self._time = ListenedTime(HEARTBEAT_S)
        self._heard: dict[str, tuple[float, float]] = {}  # s of listening, and of the wall clock

    def join(self, node: AgentBase) -> None:
        """Keep ``node.unreached`` up to date from now on."""
        settings = node.settings
        needed = tuple(filter(None, (settings.commander, *settings.superiors))) or (OPERATOR,)
        if not self._groups:
            self._shared.scheduler.every(HEARTBEAT_S, self._look)
        if OPERATOR in {*needed} - self._watched:
            topic = names.in_swarm(self._node, names.OPERATORS)
            self._node.create_subscription(
                msg.Alive, topic, lambda sign: self._note(OPERATOR), qos.SIGNS_OF_LIFE
            )
        elif not self._watched - {OPERATOR}:
            hosts = names.in_swarm(self._node, names.HOSTS)
            self._rosters = self._rosters or HostRosters(self._node, hosts)
            self._shared.signs.follow("", self._hear)
        self._watched.update(needed)
        self._groups.setdefault((needed, settings.out_of_reach_after), []).append(node)

    def _hear(self, sign: msg.Alive) -> None:
        assert self._rosters is not None, "who listens has rosters"
        rosters = self._rosters
        for name in self._watched:
            speaks = sign.process in (name, *rosters.hosts_of.get(name, ()))
            if speaks and rosters.believes(sign.process, name):
                self._note(name)

    def _note(self, name: str) -> None:
        self._heard[name] = self._time.now(), time.time()

    def _look(self) -> None:
        for (needed, after), nodes in self._groups.items():
            why = next(filter(None, (self._why(name, after) for name in needed)), "")
            for node in nodes:
                node.unreached = why
                if node.stop is None:  # otherwise the robot's stop shows it as its cause
                    node.guard.faults.set("reach", why)

    def _why(self, name: str, after: float) -> str:
        listened, at = self._heard.get(name, (float("inf"), 0.0))
        if self._shared.exchange.is_here(name) or self._time.now() - listened <= after:
            return ""
        since = time.strftime("%H:%M:%S", time.localtime(at))
        return f"{name} is out of reach: silent since {since}"
