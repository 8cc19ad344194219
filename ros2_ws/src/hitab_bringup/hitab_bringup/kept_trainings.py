"""The names of trainings that agents keep while they are idle or perform something else."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hitab_msgs.msg import AgentStatus

    from hitab_client import SwarmClient


class KeptTrainings:
    """Asks agents for what they keep: a status names only a training that is under way."""

    def __init__(self, agents: SwarmClient) -> None:
        self._agents = agents
        self._known: dict[str, tuple[tuple[object, ...], str]] = {}

    def name(self, status: AgentStatus) -> str:
        """Return the name of an agent's training, under way or kept; "" if there is none.

        An agent that does not answer is asked again only when its status changes.
        """
        from hitab_client import SwarmError

        if status.mode in (status.TRAINING, status.TESTING):
            return str(status.behavior)
        if not status.examples:
            return ""
        key = (status.mode, status.behavior, status.examples, status.library_digest)
        if self._known.get(status.agent, ((), ""))[0] != key:
            self._known[status.agent] = key, ""
            with suppress(SwarmError):
                self._known[status.agent] = key, self._agents.behavior(status.agent).name
        return self._known[status.agent][1]
