"""Observer of what agents in training would do next, for their statuses.

It looks between callbacks, and only while somebody reads the status. A status is published when
the next state, the rounded probability, or whether the agent is sure has changed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import Scheduler
from hitab_core import TrainingSession
from hitab_ros.timing import UPDATE_S


class PreviewWatch:
    """Looks what the agents of a process would do next."""

    def __init__(self, nodes: Sequence[AgentBase], scheduler: Scheduler) -> None:
        """Watch the agents from now on.

        Args:
            nodes: the nodes of the agents, read at each look.
            scheduler: the process's scheduler.
        """
        self._nodes = nodes
        scheduler.every(2 * UPDATE_S, self._look)  # people cannot read what changes faster

    def _look(self) -> None:
        for node in self._nodes:
            trained = node.agent.trained
            if trained is not None and node.status.is_read:
                doing = "looking what it would do next"
                node.guard.run(doing, self._see, trained, node.status)

    def _see(self, trained: TrainingSession, status: Any) -> None:
        trained.preview.learn()
        now, before = trained.preview.now(), status.preview
        now = replace(now, probability=round(now.probability, 1))
        if now.unsure and before.unsure:  # its distance changes with each percept
            now = replace(now, unsure=before.unsure)
        if now != before:
            status.preview = now
            status.publish_soon()
