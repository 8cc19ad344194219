"""Logs foreign text and repeated failures without filling the disk."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable

from hitab_core import quantity
from hitab_ros.messages.plain_text import plain
from hitab_ros.timing import REMIND_S

BURST = 20
"""Maximum number of lines in a burst."""

CAUSES_MAX = 500
"""Maximum number of causes remembered."""


class SparingLog:
    """Writes equal texts once, and different texts at a limited rate."""

    def __init__(
        self,
        write: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        refill_s: float = REMIND_S,
    ) -> None:
        """Create a log.

        Args:
            write: writes a line.
            clock: returns the time in seconds.
            refill_s: time, s, after which one more line is allowed.
        """
        self._write = write
        self._refill_s = refill_s
        self._clock = clock
        self._seen: dict[Hashable, None] = {}
        self._left = float(BURST)
        self._at = clock()
        self._left_out = 0

    def __call__(self, text: str, cause: Hashable = None, limit: int = 1000) -> None:
        """Write a text, unless it repeats an earlier one or exceeds the rate.

        Args:
            text: text to write.
            cause: identifies repetitions; the text itself by default.
            limit: maximum characters written.
        """
        cause = text if cause is None else cause
        if cause in self._seen:
            return
        now = self._clock()
        self._left = min(BURST, self._left + (now - self._at) / self._refill_s)
        self._at = now
        if self._left < 1.0:
            self._left_out += 1
            return
        self._left -= 1.0
        if len(self._seen) >= CAUSES_MAX:
            del self._seen[next(iter(self._seen))]
        self._seen[cause] = None
        text = plain(text, limit)
        if self._left_out:
            text += f" ({quantity(self._left_out, 'other message')} dropped before this one)"
            self._left_out = 0
        self._write(text)
