"""Timeouts that allow for a busy machine."""

from __future__ import annotations

import time

BUSY_FACTOR = 5.0
"""Maximum factor by which a busy machine prolongs a wait."""


class BusyTimeout:
    """Timeout of a number of seconds, waited for in steps.

    CPU-starved time is not counted, since the awaited process is starved too.
    """

    def __init__(self, seconds: float) -> None:
        self._left = seconds
        self._looked = time.monotonic()
        self._end = self._looked + BUSY_FACTOR * seconds
        self._used = time.process_time()
        self._step = 0.0

    def step(self, longest: float) -> float:
        """Return the time to wait before the next check, s; 0 once the timeout is over.

        Args:
            longest: maximum time, s.
        """
        looked, used = time.monotonic(), time.process_time()
        self._left -= min(looked - self._looked, self._step + used - self._used)
        self._looked, self._used = looked, used
        self._step = 0.0 if looked > self._end else min(longest, max(self._left, 0.0))
        return self._step
