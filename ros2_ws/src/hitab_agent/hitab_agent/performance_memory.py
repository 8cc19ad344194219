"""What an agent performs, kept across a restart of its process by the same swarm."""

from __future__ import annotations

from pathlib import Path

from hitab_agent.line_memory import LineMemory
from hitab_core import Agent

FILE_NAME = "performance.json"


class PerformanceMemory:
    """A file in an agent's state folder.

    It is valid for the swarm that wrote it: the agents of another swarm start as their
    description says. An agent outside any swarm is started by a person, who says what it should
    do.

    Attributes:
        performed: the top-level behavior before the restart, empty if there was none; None if
            this is the agent's first start in its swarm.
        damage: why the file is ignored; empty if it is not.
    """

    def __init__(self, folder: Path, swarm: str) -> None:
        """Read the file.

        Args:
            folder: the folder of the file.
            swarm: identity of the agent's swarm; empty: none.
        """
        self._swarm = swarm
        self._file = LineMemory(folder / FILE_NAME)
        self.damage = self._file.damage if swarm else ""
        self.performed: str | None = None
        behavior = self._file.values.get("behavior")
        if swarm and self._file.values.get("swarm") == swarm and isinstance(behavior, str):
            self.performed = behavior

    def first(self, behavior: str, *, resume: bool) -> str:
        """Return what to perform at the start.

        Args:
            behavior: what the agent should perform at its first start; empty: nothing.
            resume: whether it continues after a restart; otherwise it comes back idle.
        """
        if self.performed is None:
            return behavior
        return self.performed if resume else ""

    def restarted(self, agent: Agent) -> str:
        """Say of an agent that it was restarted and what it did before; empty: its first start."""
        if self.performed is None:
            return ""
        if agent.behavior:
            return f'was restarted; it performs "{self.performed}" again, as before'
        if not self.performed:
            return "was restarted; it was idle before, too"
        return (
            f'was restarted and is idle; it performed "{self.performed}" before: '
            f"`hitab perform {agent.name} '{self.performed}'` has it perform that again"
        )

    def keep(self, behavior: str) -> None:
        """Save what is performed now, if that has changed.

        Raises:
            OSError: if it cannot be written.
        """
        values = {"swarm": self._swarm, "behavior": behavior}
        if self._swarm and values != self._file.values:
            self._file.write(values)
