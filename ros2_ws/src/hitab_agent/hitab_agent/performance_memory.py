"""What an agent performs, kept across a restart of its process by the same swarm."""

from __future__ import annotations

from pathlib import Path

from hitab_agent.line_memory import LineMemory

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

    def first(self, behavior: str) -> str:
        """Return what to perform at the start.

        Args:
            behavior: what the agent should perform at its first start; empty: nothing.
        """
        return behavior if self.performed is None else self.performed

    def restarted(self) -> str:
        """Say of an agent that it was restarted and what it did before; empty: its first start."""
        if self.performed is None:
            return ""
        if not self.performed:
            return "was restarted; it was idle before, too"
        return f'was restarted; it performs "{self.performed}" again, as before'

    def keep(self, behavior: str) -> None:
        """Save what is performed now, if that has changed.

        Raises:
            OSError: if it cannot be written.
        """
        values = {"swarm": self._swarm, "behavior": behavior}
        if self._swarm and values != self._file.values:
            self._file.write(values)
