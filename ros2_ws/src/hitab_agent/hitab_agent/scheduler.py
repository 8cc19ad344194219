"""Scheduling of work that need not be done at once: calls at fixed rates, and queued jobs."""

from __future__ import annotations

import sys
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from threading import Thread
from typing import Any

from hitab_ros import Guard, GuardedNode, name_of, steady_timer
from hitab_ros.timing import TURN_S

Call = Callable[[], Any]

SLICE_S = 0.005
"""How long queued jobs run before other callbacks get their turn; far less than a cycle."""

Job = Iterator[Future[Any] | None]
"""A job yields where it may be interrupted: None, or a call that must end before it continues."""


def in_background(call: Call) -> Future[Any]:
    """Begin a call in its own thread.

    Such a call may wait for the disk or read frozen data; it must not touch nodes or agents. A
    thread of an executor would keep the process from ending.
    """
    future: Future[Any] = Future()

    def run() -> None:
        try:
            future.set_result(call())
        except Exception as error:  # result() raises it again
            future.set_exception(error)

    Thread(target=run, daemon=True).start()
    return future


class Scheduler:
    """Calls functions at fixed rates; the agents of a host share its timers, one per rate.

    The timers use the machine's clock, never simulated time: the calls must continue while a world
    is paused.
    """

    def __init__(self, node: GuardedNode) -> None:
        self._node = node
        self._rates: dict[float, _Rate] = {}

    def every(self, seconds: float, call: Call, guard: Guard | None = None) -> Call:
        """Call a function every so many seconds from now on; return a function that ends this.

        Args:
            seconds: time between two calls, s.
            call: the function.
            guard: guard of the agent whose status shows a failure; None for the node's guard.
        """
        if seconds not in self._rates:
            self._rates[seconds] = _Rate(self._node, seconds)
        guard = guard or self._node.guard
        return self._rates[seconds].add(guard.wrap(name_of(call), call))


class _Rate:
    """Functions that are called at one rate."""

    def __init__(self, node: GuardedNode, seconds: float) -> None:
        self._seconds = seconds
        self._calls: list[Call] = []
        self._turns = 1
        self._turn = 0
        self._timer = steady_timer(node, seconds, self._next)

    def add(self, call: Call) -> Call:
        self._calls.append(call)
        self._take_turns()

        def end() -> None:
            self._calls.remove(call)
            self._take_turns()

        return end

    def _take_turns(self) -> None:
        # Functions of one rate are called in turns, so that a host with hundreds of them does
        # not delay an order until all have run.
        turns = max(1, min(len(self._calls), int(self._seconds / (2 * TURN_S))))
        if turns != self._turns:
            self._turns = turns
            self._timer.timer_period_ns = round(self._seconds / turns * 1e9)
            self._timer.reset()

    def _next(self) -> None:
        calls, turns = self._calls, self._turns
        turn = self._turn = (self._turn + 1) % turns
        for call in calls[len(calls) * turn // turns : len(calls) * (turn + 1) // turns]:
            call()


class JobQueue:
    """Jobs done in order, a slice per period, so that percepts and orders come in between.

    The timer runs only while there are jobs.
    """

    def __init__(
        self, node: GuardedNode, period_s: float = SLICE_S / 5, at_most: int | None = None
    ) -> None:
        """Create the timer, stopped.

        Args:
            node: the node that owns the timer.
            period_s: time between two slices, s.
            at_most: maximum number of steps in one slice; None if only `SLICE_S` limits it.
        """
        self._guard = node.guard
        self._at_most = at_most or sys.maxsize
        self._jobs: deque[tuple[str, Job, Guard]] = deque()
        self._awaited: Future[Any] | None = None
        self._timer = steady_timer(node, period_s, self._slice)
        self._timer.cancel()

    def do(self, job: Job, guard: Guard | None = None, name: str = "") -> None:
        """Do a job after those already waiting.

        Args:
            job: the job's steps.
            guard: guard of the agent whose status shows a failure; None for the node's guard.
            name: the job's name in that status; empty for the name of its function.
        """
        if not self._jobs:
            self._timer.reset()
        name = name or getattr(job, "__qualname__", "job")
        self._jobs.append((name, job, guard or self._guard))

    def call(self, call: Call, guard: Guard | None = None) -> None:
        """Call a function, as a job of one step."""
        self.do(_once(call), guard, name_of(call))

    def _slice(self) -> None:
        until = time.monotonic() + SLICE_S
        for _ in range(self._at_most):
            if not self._jobs or (self._awaited is not None and not self._awaited.done()):
                break
            self._step(*self._jobs[0])
            if time.monotonic() >= until:
                break
        if not self._jobs:
            self._timer.cancel()

    def _step(self, name: str, job: Job, guard: Guard) -> None:
        self._awaited, is_over = None, True  # a step that raises ends its job

        def step() -> None:
            nonlocal is_over
            for self._awaited in job:
                is_over = False
                break

        guard.run(name, step)
        if is_over:
            self._jobs.popleft()


def _once(call: Call) -> Job:
    call()
    yield from ()
