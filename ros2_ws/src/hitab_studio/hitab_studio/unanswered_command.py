"""Commands that an agent did not acknowledge, and that a person may send again."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_client import is_answered
from hitab_studio.swarm_state import SwarmState


@dataclass(frozen=True)
class UnansweredCommand:
    """A command that its agent has not acknowledged.

    Attributes:
        agent: receiver of the command.
        behavior: the commanded behavior, with targets.
        sequence: number of the command, unchanged when sent again; 0 for a request to perform.
    """

    agent: str
    behavior: str
    sequence: int

    def is_taken(self, known: SwarmState) -> bool:
        """Whether the agent has acknowledged the command after all, by its status."""
        status = known.statuses.get(self.agent)
        if status is None or not known.answers(self.agent):
            return False
        if self.sequence:
            return is_answered(status, self.sequence)
        return bool(status.behavior == self.behavior)
