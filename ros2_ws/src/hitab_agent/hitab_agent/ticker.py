"""Calling functions at fixed rates, with one timer for all of the same rate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

Call = Callable[[], None]


class Ticker:
    """Makes timers on a node; the agents of a host share one of these, and so their timers.

    Time is that of the machine, never simulated time: what is called has to happen also while a
    world is paused.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = Clock(clock_type=ClockType.STEADY_TIME)
        self._calls: dict[float, list[Call]] = {}
        self._timers: list[Any] = []

    def every(self, seconds: float, call: Call) -> None:
        """Call a function every so many seconds, from now on."""
        calls = self._calls.get(seconds)
        if calls is None:
            calls = self._calls[seconds] = []
            self._timers.append(
                self._node.create_timer(seconds, lambda: _all(calls), clock=self._clock)
            )
        calls.append(call)

    def seconds(self) -> float:
        """Return the time, s, from an arbitrary beginning; it never goes back."""
        return float(self._clock.now().nanoseconds) * 1e-9


def _all(calls: list[Call]) -> None:
    for call in calls:
        call()
