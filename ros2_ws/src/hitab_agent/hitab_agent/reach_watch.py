"""Watches whether an agent's commander is in reach or, without one, a person's console."""

from __future__ import annotations

import math

from hitab_msgs import msg

from hitab_agent.agent_base import AgentBase
from hitab_ros import names, qos

SILENCE_PERIOD_S = 0.5
"""Period of the check, s."""


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
        # Counted in checks, not by a clock: a process that gets no CPU would see silence.
        self._unheard_s = -math.inf
        topic = names.in_swarm(node, names.ALIVE if self._commander else names.OPERATORS)
        node.create_subscription(msg.Alive, topic, self._hear, qos.SIGNS_OF_LIFE)
        node.shared.scheduler.every(SILENCE_PERIOD_S, self._look, node.guard)

    def _hear(self, sign: msg.Alive) -> None:
        if not self._commander or self._commander in (sign.process, *sign.agents):
            self._unheard_s = 0.0

    def _look(self) -> None:
        self._unheard_s += SILENCE_PERIOD_S
        after = self._node.settings.out_of_reach_after
        who = self._commander or "the operator"
        lost = f"{who} is out of reach: silent for {after:g} s"
        self.why = lost if self._unheard_s > after else ""
        if self._node.stop is None:  # otherwise the robot's stop shows it as its cause
            self._node.guard.faults.set("reach", self.why)
