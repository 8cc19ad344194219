"""Doing things a little later, many of them with one timer."""

from __future__ import annotations

from collections.abc import Callable

from rclpy.clock import Clock, ClockType
from rclpy.node import Node


class Later:
    """Calls what was put into it within a period, all together, and then rests.

    Attributes:
        period_s: how late things are done at most.
    """

    def __init__(self, node: Node, period_s: float) -> None:
        self.period_s = period_s
        self._calls: list[Callable[[], None]] = []
        self._timer = node.create_timer(
            period_s, self._due, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )
        self._timer.cancel()

    def slow_down(self, period_s: float) -> None:
        """Do things later than that."""
        self.period_s = period_s
        self._timer.timer_period_ns = round(period_s * 1e9)

    def call(self, call: Callable[[], None]) -> None:
        """Call a function soon."""
        if not self._calls:
            self._timer.reset()
        self._calls.append(call)

    def _due(self) -> None:
        self._timer.cancel()
        calls, self._calls = self._calls, []
        for call in calls:
            call()
