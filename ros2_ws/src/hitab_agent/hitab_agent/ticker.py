"""Calling functions at fixed rates, with one timer per rate."""

from __future__ import annotations

from collections.abc import Callable

from hitab_ros import Guard, GuardedNode, name_of, steady_timer

Call = Callable[[], None]

TURN_S = 0.02
"""The functions of one rate are called in turns at least this far apart, so that a host with
hundreds of them does not delay an order until all have run."""


class Ticker:
    """Creates timers on a node; the agents of a host share one ticker and its timers.

    It uses the machine's clock, never simulated time: the calls must go on while a world is
    paused.
    """

    def __init__(self, node: GuardedNode) -> None:
        self._node = node
        self._rates: dict[float, _Rate] = {}

    def every(self, seconds: float, call: Call, guard: Guard | None = None) -> None:
        """Call a function every so many seconds, from now on.

        Args:
            seconds: between two calls, s.
            call: the function.
            guard: of the agent whose status shows a failure; None: that of the node.
        """
        if seconds not in self._rates:
            self._rates[seconds] = _Rate(self._node, seconds)
        guard = guard or self._node.guard
        self._rates[seconds].add(guard.wrap(name_of(call), call))


class _Rate:
    """Functions that are called equally often."""

    def __init__(self, node: GuardedNode, seconds: float) -> None:
        self._seconds = seconds
        self._calls: list[Call] = []
        self._turns = 1
        self._turn = 0
        self._timer = steady_timer(node, seconds, self._next)

    def add(self, call: Call) -> None:
        self._calls.append(call)
        turns = min(len(self._calls), max(1, int(self._seconds / TURN_S)))
        if turns != self._turns:
            self._turns = turns
            self._timer.timer_period_ns = round(self._seconds / turns * 1e9)
            self._timer.reset()

    def _next(self) -> None:
        calls, turns = self._calls, self._turns
        turn = self._turn = (self._turn + 1) % turns
        for call in calls[len(calls) * turn // turns : len(calls) * (turn + 1) // turns]:
            call()
