"""Commands that an agent has not taken, because it hangs or has ended, to be sent again."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_client import is_answered
from hitab_studio.swarm_state import SwarmState

TAKEN_SECONDS = 2.0
"""Time without an acknowledgement after which a command is reported as lost."""


@dataclass(frozen=True)
class UnansweredCommand:
    """A command that its agent has not acknowledged.

    Attributes:
        agent: receiver of the command.
        behavior: with its targets.
        sequence: number of the command, the same when it is sent again; 0 if it was asked to
            perform, without a number.
    """

    agent: str
    behavior: str
    sequence: int

    def is_taken(self, known: SwarmState) -> bool:
        """Whether the agent's status shows the command as taken after all."""
        status = known.statuses.get(self.agent)
        if status is None or not known.answers(self.agent):
            return False
        if self.sequence:
            return is_answered(status, self.sequence)
        return bool(status.behavior == self.behavior)
