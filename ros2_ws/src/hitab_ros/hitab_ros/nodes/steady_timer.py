"""Timers by the machine's clock, which runs on while simulated time stands still."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node


def steady_timer(node: Node, seconds: float, callback: Callable[[], Any]) -> Any:
    """Create a timer on a node that no simulated time and no change of the date affects.

    Args:
        node: owns the timer.
        seconds: time between two calls, s.
        callback: called periodically.
    """
    return node.create_timer(seconds, callback, clock=Clock(clock_type=ClockType.STEADY_TIME))
