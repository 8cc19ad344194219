"""Passes values from one thread to the event loop of another."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

T = TypeVar("T")

MOST = 200
"""Maximum number of waiting values; beyond it, the oldest are dropped."""


class Mailbox(Generic[T]):
    """Takes values from any thread and passes them to a function that runs in a loop.

    Args:
        loop: the event loop.
        take: called with all new values, oldest first.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, take: Callable[[Sequence[T]], None]
    ) -> None:
        self._loop = loop
        self._take = take
        self._values: deque[T] = deque(maxlen=MOST)

    def post(self, value: T) -> None:
        """Pass a value, which must not change afterwards; ignored after the end of the loop."""
        self._values.append(value)
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._open)

    def _open(self) -> None:
        found = []
        while self._values:
            found.append(self._values.popleft())
        if found:
            self._take(found)
