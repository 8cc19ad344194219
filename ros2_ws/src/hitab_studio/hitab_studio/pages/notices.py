"""Notices: short messages on a page about successes and failures."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

NOTICE_SECONDS = {"good": 5.0, "note": 10.0, "bad": 30.0}
"""Time for which a notice is shown unless closed, by kind."""

NOTICES_MAX = 3
"""Notices shown at once; a new one replaces the oldest."""


@dataclass
class Notice:
    """A short message.

    Attributes:
        number: identity of the notice on the page.
        kind: good (success), note (nothing done, or done by others) or bad (failure).
        times: number of times the message was issued since first shown.
        until: time of removal on the monotonic clock, s.
    """

    number: int
    kind: str
    text: str
    times: int
    until: float


class Notices:
    """The notices of a page, oldest first, each text at most once.

    Args:
        clock: returns the time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.shown: list[Notice] = []
        self._clock = clock
        self._numbers = 0

    def say(self, text: str, kind: str = "good") -> None:
        """Show a message, or count the repetition of a shown one."""
        until = self._clock() + NOTICE_SECONDS[kind]
        for message in self.shown:
            if message.text == text and message.kind == kind:
                message.times += 1
                message.until = until
                return
        self._numbers += 1
        self.shown = [*self.shown[1 - NOTICES_MAX :], Notice(self._numbers, kind, text, 1, until)]

    def close(self, number: int) -> None:
        """Remove the notice with this number."""
        self.shown = [message for message in self.shown if message.number != number]

    def withdraw(self, text: str) -> None:
        """Remove a message that is no longer true."""
        self.shown = [message for message in self.shown if message.text != text]

    def drop_old(self) -> bool:
        """Remove expired notices; return whether there were any."""
        now, before = self._clock(), len(self.shown)
        self.shown = [message for message in self.shown if message.until >= now]
        return len(self.shown) < before
