"""Long jobs done in slices, so that percepts and orders get their turn in between."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from threading import Thread
from typing import Any

from rclpy.node import Node

from hitab_ros import steady_timer

SLICE_S = 0.005
"""How long a job runs before something else gets its turn; far less than a cycle."""

PAUSE_S = 0.001
"""The pause in which something else can start."""


def in_background(call: Callable[[], Any]) -> Future[Any]:
    """Begin a call in its own thread.

    Use it for calls that wait for the disk or only read what does not change; they must not touch
    nodes or agents. A thread of an executor would keep the process from ending.
    """
    future: Future[Any] = Future()

    def run() -> None:
        try:
            future.set_result(call())
        except Exception as error:  # raised again where the result is asked for
            future.set_exception(error)

    Thread(target=run, daemon=True).start()
    return future


Job = Iterator[Future[Any] | None]
"""Yields where it may be interrupted: None, or the call it has to wait for."""


class Slices:
    """Runs jobs one after the other, each in slices of a few milliseconds."""

    def __init__(self, node: Node) -> None:
        """Create the timer, stopped until there is a job."""
        self._jobs: deque[Job] = deque()
        self._awaited: Future[Any] | None = None
        self._timer = steady_timer(node, PAUSE_S, self._turn)
        self._timer.cancel()

    def do(self, job: Job) -> None:
        """Run a job after those already waiting."""
        if not self._jobs:
            self._timer.reset()
        self._jobs.append(job)

    def _turn(self) -> None:
        until = time.monotonic() + SLICE_S
        try:
            while self._jobs and time.monotonic() < until:
                if self._awaited is not None and not self._awaited.done():
                    break
                try:
                    self._awaited = next(self._jobs[0])
                except BaseException as error:
                    self._awaited = None
                    self._jobs.popleft()
                    if not isinstance(error, StopIteration):
                        raise
        finally:
            if not self._jobs:
                self._timer.cancel()
