"""Tools for tests of nodes: an isolated ROS domain, and waiting for conditions."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import rclpy
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.signals import SignalHandlerOptions

from hitab_ros.ros_domains import reserved_domain


@contextmanager
def context_of_its_own() -> Iterator[Context]:
    """Yield a context in a ROS domain that no other test on this machine uses."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = Context()
    with reserved_domain() as number:
        rclpy.init(
            context=context, domain_id=number, signal_handler_options=SignalHandlerOptions.NO
        )
        try:
            yield context
        finally:
            context.try_shutdown()


SECONDS = 60.0
"""Timeout of tests, s: longer than any wait, even on a busy machine."""


def wait_until(condition: Callable[[], Any]) -> None:
    """Wait, handling no events, until a condition holds.

    Raises:
        AssertionError: if the condition does not hold within a minute.
    """
    deadline = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        time.sleep(0.01)


def spin_until(
    executor: Executor, condition: Callable[[], Any], each: Callable[[], Any] = lambda: None
) -> None:
    """Handle events until a condition holds.

    Args:
        executor: executor of the nodes.
        condition: condition to wait for.
        each: called repeatedly meanwhile.

    Raises:
        AssertionError: if the condition does not hold within a minute.
    """
    deadline = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < deadline, "it did not happen in time"
        each()
        executor.spin_once(timeout_sec=0.02)
