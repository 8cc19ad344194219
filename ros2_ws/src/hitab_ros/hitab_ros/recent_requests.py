"""Recently answered requests, so that a repeated request is not carried out twice.

A client repeats a request if the answer is late, since the request or the answer may be lost.
Other clients may send requests in between.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Generic, TypeVar

from hitab_ros.timing import ANSWER_S

Answer = TypeVar("Answer")

ANSWERS_MAX = 1000
"""Maximum number of answers remembered."""


class RecentRequests(Generic[Answer]):
    """The answers to recent requests, by client and number."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        """Start empty; ``clock`` returns the time in seconds."""
        self._clock = clock
        self._kept: dict[tuple[str, int], tuple[float, Answer]] = {}

    def came_of(self, client: str, number: int) -> Answer | None:
        """Return the answer to a request, or None if the request is new."""
        found = self._kept.get((client, number))
        return found[1] if found is not None and self._clock() - found[0] <= 4 * ANSWER_S else None

    def keep(self, client: str, number: int, answer: Answer) -> None:
        """Store an answer, if the client numbers its requests."""
        if not number:
            return
        key = (client, number)
        self._kept.pop(key, None)
        now = self._clock()
        self._kept[key] = (now, answer)
        # The oldest come first; drop those that are too old or too many.
        while (
            len(self._kept) > ANSWERS_MAX
            or now - next(iter(self._kept.values()))[0] > 4 * ANSWER_S
        ):
            del self._kept[next(iter(self._kept))]
