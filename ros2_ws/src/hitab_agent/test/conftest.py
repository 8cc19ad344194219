"""A process for the tests: real nodes over real topics, handled by the test itself."""

import contextlib
import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from domain_coordinator import domain_id
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.node import Node

SECONDS = 20.0


class Process:
    """A node, and others where a test adds them, in a ROS domain of its own."""

    def __init__(self, node: Node, executor: EventsExecutor) -> None:
        self.node = node
        self._executor = executor
        self._nodes: list[Node] = []
        self.add(node)

    def add(self, node: Node) -> None:
        """Have another node in it; it is taken down at the end."""
        self._executor.add_node(node)
        self._nodes.append(node)

    def close(self) -> None:
        for node in self._nodes:
            self._executor.remove_node(node)
            node.destroy_node()
        self._executor.shutdown()

    def until(self, condition: Callable[[], Any]) -> None:
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        deadline = clock.now().nanoseconds + int(SECONDS * 1e9)
        while not condition():
            assert clock.now().nanoseconds < deadline, "it did not happen in time"
            self._executor.spin_once(timeout_sec=0.02)

    def meanwhile(self, done: list[Any], seconds: float = 0.005) -> None:
        """Do something else, again and again."""
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.node.create_timer(seconds, lambda: done.append("something else"), clock=clock)


@pytest.fixture
def process() -> Iterator[Process]:
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with contextlib.ExitStack() as stack:
        context = Context()
        rclpy.init(
            context=context,
            domain_id=stack.enter_context(domain_id()),
            signal_handler_options=rclpy.signals.SignalHandlerOptions.NO,
        )
        stack.callback(context.try_shutdown)
        node = rclpy.create_node("host", context=context, enable_rosout=False)
        executor = EventsExecutor(context=context)
        made = Process(node, executor)
        stack.callback(made.close)
        yield made
