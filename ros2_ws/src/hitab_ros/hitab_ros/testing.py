"""For tests of nodes: an isolated ROS domain."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

import rclpy
from domain_coordinator import domain_id
from rclpy.context import Context
from rclpy.signals import SignalHandlerOptions


@contextmanager
def context_of_its_own() -> Iterator[Context]:
    """Yield a context in a ROS domain, on this machine, that no other test uses."""
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = Context()
    with domain_id() as number:
        rclpy.init(
            context=context, domain_id=number, signal_handler_options=SignalHandlerOptions.NO
        )
        try:
            yield context
        finally:
            context.try_shutdown()
