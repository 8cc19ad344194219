"""Hands what one thread knows to the loop of another."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

T = TypeVar("T")

MOST = 200
"""Values that wait; of more, the oldest are dropped."""


class Mailbox(Generic[T]):
    """Takes values, from any thread, and gives them to a function that runs in a loop.

    Args:
        loop: in which.
        take: is given all values that have come since, oldest first.
    """

    def __init__(
        self, loop: asyncio.AbstractEventLoop, take: Callable[[Sequence[T]], None]
    ) -> None:
        self._loop = loop
        self._take = take
        self._values: deque[T] = deque(maxlen=MOST)

    def post(self, value: T) -> None:
        """Hand over a value, which nobody changes from now on; after the loop's end, nothing."""
        self._values.append(value)
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._open)

    def _open(self) -> None:
        found = []
        while self._values:
            found.append(self._values.popleft())
        if found:
            self._take(found)
