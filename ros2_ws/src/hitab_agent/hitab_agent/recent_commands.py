"""Commands that were obeyed or refused a moment ago, so that one sent again is not obeyed twice.

A demonstrator sends a command again if its acknowledgement is late. In between others may have
commanded too, and their commands stand in the status by then.
"""

from __future__ import annotations

import time
from collections.abc import Callable

MEMORY_S = 15.0
"""How long a command is remembered; nobody sends one again for longer than that."""

MOST = 1000
"""How many are remembered at the most."""


class RecentCommands:
    """What came of recent commands, by demonstrator and sequence number."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Remember nothing yet; ``clock`` tells the time in seconds."""
        self._clock = clock
        self._kept: dict[tuple[str, int], tuple[float, str]] = {}

    def came_of(self, demonstrator: str, sequence: int) -> str | None:
        """Return why a command was refused, "" if it was obeyed, None if it is a new one."""
        when, error = self._kept.get((demonstrator, sequence), (0.0, None))
        return error if error is not None and self._clock() - when <= MEMORY_S else None

    def keep(self, demonstrator: str, sequence: int, error: str) -> None:
        """Remember what came of a command; ``error`` as `came_of` returns it."""
        if not sequence:
            return  # its sender does not number its commands
        key = (demonstrator, sequence)
        self._kept.pop(key, None)
        self._kept[key] = (self._clock(), error)
        if len(self._kept) > MOST:
            del self._kept[next(iter(self._kept))]
