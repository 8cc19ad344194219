"""Notices: short messages on a page about successes and failures."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

NOTICE_SECONDS = {"good": 5.0, "note": 10.0, "bad": 30.0}
"""How long a message stays unless a person closes it."""

NOTICES_MAX = 3
"""Messages that are shown at once; an older one makes room."""


@dataclass
class Notice:
    """A short message.

    Attributes:
        number: identity of the notice on the page.
        kind: good (it was done), note (nothing was done, or by others) or bad (it failed).
        times: how often it was said since it was first shown.
        until: when it goes, on the monotonic clock, s.
    """

    number: int
    kind: str
    text: str
    times: int
    until: float


class Notices:
    """The notices of a page, oldest first; the same text is there once.

    Args:
        clock: the time, s.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.shown: list[Notice] = []
        self._clock = clock
        self._numbers = 0

    def say(self, text: str, kind: str = "good") -> None:
        """Show a message, or count it if it is shown already."""
        until = self._clock() + NOTICE_SECONDS[kind]
        for message in self.shown:
            if message.text == text and message.kind == kind:
                message.times += 1
                message.until = until
                return
        self._numbers += 1
        self.shown = [*self.shown[1 - NOTICES_MAX :], Notice(self._numbers, kind, text, 1, until)]

    def close(self, number: int) -> None:
        """Remove a message."""
        self.shown = [message for message in self.shown if message.number != number]

    def withdraw(self, text: str) -> None:
        """Remove a message that does not hold any more."""
        self.shown = [message for message in self.shown if message.text != text]

    def drop_old(self) -> bool:
        """Remove what was shown long enough; return whether there was such."""
        now, before = self._clock(), len(self.shown)
        self.shown = [message for message in self.shown if message.until >= now]
        return len(self.shown) < before
