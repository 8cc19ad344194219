"""Watches whether an agent's commander is in reach or, without one, a person's console."""

from __future__ import annotations

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_ros import HostRosters, Presence, names, qos
from hitab_ros.timing import HEARTBEAT_S


class ReachWatch:
    """Listens for heartbeats of an agent's commander; without one, of people's consoles.

    A commander or console that was never heard does not count as lost.

    Attributes:
        why: why no commander or console is in reach; empty if one is.
    """

    def __init__(self, node: AgentBase) -> None:
        """Begin to listen."""
        self.why = ""
        self._node = node
        self._commander = node.settings.commander
        self._who = self._commander or "the operator"
        self._after = node.settings.out_of_reach_after
        self._presence = Presence(self._after, HEARTBEAT_S)
        hosts = names.in_swarm(node, names.HOSTS)
        swarm = node.settings.swarm
        self._rosters = node.shared.rosters or HostRosters(
            node, hosts, lambda roster: swarm in ("", roster.swarm)
        )
        topic = names.in_swarm(node, names.ALIVE if self._commander else names.OPERATORS)
        node.create_subscription(msg.Alive, topic, self._hear, qos.SIGNS_OF_LIFE)
        node.shared.scheduler.every(HEARTBEAT_S, self._look, node.guard)

    def _hear(self, sign: msg.Alive) -> None:
        commander, rosters = self._commander, self._rosters
        speaks = sign.process in (commander, *rosters.hosts_of.get(commander, ()))
        if not commander or (speaks and rosters.believes(sign.process, commander)):
            self._presence.hear(self._who)

    def _look(self) -> None:
        lost = f"{self._who} is out of reach: silent for {self._after:g} s"
        self.why = lost if self._presence.silent() else ""
        if self._node.stop is None:  # otherwise the robot's stop shows it as its cause
            self._node.guard.faults.set("reach", self.why)
