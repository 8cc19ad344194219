"""Observer of what agents in training would do next, for their statuses.

It looks between callbacks, and only while somebody reads the status. A status is published when
the next state, the rounded probability, or whether the agent is sure has changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import Scheduler
from hitab_core import Mode
from hitab_ros.timing import UPDATE_S

LOOK_S = 2 * UPDATE_S
"""Period of the looks, s: people cannot read what changes faster."""


class PreviewWatch:
    """Looks what the agents of a process would do next."""

    def __init__(self, nodes: Sequence[AgentBase], scheduler: Scheduler) -> None:
        """Watch the agents from now on.

        Args:
            nodes: the nodes of the agents, read at each look.
            scheduler: the process's scheduler.
        """
        self._nodes = nodes
        scheduler.every(LOOK_S, self._look)

    def _look(self) -> None:
        for node in self._nodes:
            if node.agent.mode in (Mode.TRAINING, Mode.TESTING) and node.status.is_read:
                node.guard.run("looking what it would do next", self._see, node)

    def _see(self, node: AgentBase) -> None:
        session, status = node.agent.session, node.status
        if session is None:
            return
        session.preview.learn()
        now, before = session.preview.now(), status.preview
        now = replace(now, probability=round(now.probability, 1))
        if now.unsure and before.unsure:  # its distance changes with each percept
            now = replace(now, unsure=before.unsure)
        if now != before:
            status.preview = now
            status.publish_soon()
