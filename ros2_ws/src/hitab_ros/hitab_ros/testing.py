"""For tests of nodes: a place where nobody else is heard."""

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
    """Yield a context, on this machine, in a ROS domain that no other test uses meanwhile."""
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
