"""How late the commands of the people at the pages come."""

from __future__ import annotations

from pathlib import Path

from hitab_client import reaction_time


class Reactions:
    """The reaction times kept on this machine, read again whenever they have changed."""

    def __init__(self) -> None:
        self._read: tuple[Path, int, dict[str, float]] | None = None

    def of(self, demonstrator: str) -> float:
        """Return a demonstrator's reaction time, s; 0 if none is kept.

        Raises:
            SwarmError: if the file that keeps them cannot be read.
        """
        path = reaction_time.file()
        changed = path.stat().st_mtime_ns if path.exists() else 0
        if self._read is None or self._read[:2] != (path, changed):
            self._read = (path, changed, dict(reaction_time.kept()))
        return self._read[2].get(demonstrator, 0.0)
