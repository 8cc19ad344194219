"""Requests that were answered a moment ago, so that one that is sent again is not done twice.

A client sends a request again if its answer is late: the answer may be lost, or the request. In
between others may have asked for something too.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, TypeVar

Answer = TypeVar("Answer")

MEMORY_S = 60.0
"""How long an answer is remembered; no client sends its request again for longer than that."""

MOST = 1000
"""How many are remembered at the most."""


class RecentRequests(Generic[Answer]):
    """What came of recent requests, by client and number."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Remember nothing yet; ``clock`` tells the time in seconds."""
        self._clock = clock
        self._kept: dict[tuple[str, int], tuple[float, Answer]] = {}

    def came_of(self, client: str, number: int) -> Answer | None:
        """Return the answer that a request was given, or None if it is a new one."""
        found = self._kept.get((client, number))
        return found[1] if found is not None and self._clock() - found[0] <= MEMORY_S else None

    def keep(self, client: str, number: int, answer: Answer) -> None:
        """Remember an answer, unless the client does not number its requests."""
        if not number:
            return
        key = (client, number)
        self._kept.pop(key, None)
        now = self._clock()
        self._kept[key] = (now, answer)
        # The oldest are first: they go when they are too old, or too many.
        while len(self._kept) > MOST or now - next(iter(self._kept.values()))[0] > MEMORY_S:
            del self._kept[next(iter(self._kept))]
