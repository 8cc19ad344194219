"""Observer of decisions that are far from all examples, which people should look at.

It looks at a few of a process's agents at a time, between their callbacks, and only while
somebody reads their statuses. A status is published when an agent's decisions become far, or near
again: never for each look.
"""

from __future__ import annotations

from collections.abc import Sequence

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import Scheduler
from hitab_core import FAR, RatedFunctions, decided_at
from hitab_ros.timing import REMIND_S, UPDATE_S

LOOKS = round(REMIND_S / UPDATE_S)
"""Number of looks in which all agents have had their turn."""


class DecisionWatch:
    """Measures decisions that agents have made, and publishes which agents decide far away.

    Two consecutive looks decide, since a single situation may be unusual.
    """

    def __init__(self, nodes: Sequence[AgentBase], scheduler: Scheduler) -> None:
        """Watch the agents of a process from now on.

        Args:
            nodes: the nodes of the agents, read at each look.
            scheduler: the process's scheduler.
        """
        self._nodes = nodes
        self._rated = RatedFunctions()
        self._before: dict[str, float] = {}
        self._turn = 0
        scheduler.every(UPDATE_S, self._look)

    def _look(self) -> None:
        count, turn = len(self._nodes), self._turn
        self._turn = (turn + 1) % LOOKS
        for node in self._nodes[count * turn // LOOKS : count * (turn + 1) // LOOKS]:
            if node.status.is_read:
                node.guard.run("measuring its decisions", self._measure, node)

    def _measure(self, node: AgentBase) -> None:
        agent, status = node.agent, node.status
        now = decided_at(agent.running, agent.domain, self._rated)
        before = self._before.get(node.agent_name, 0.0)
        self._before[node.agent_name] = now
        if not status.decided_at and min(now, before) > FAR:
            status.decided_at = now
            status.publish_soon()
        elif status.decided_at and max(now, before) <= FAR:
            status.decided_at = 0.0
            status.publish_soon()
