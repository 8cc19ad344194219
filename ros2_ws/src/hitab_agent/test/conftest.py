"""A process for the tests: real nodes over real topics, handled by the test itself."""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from rclpy.clock import Clock, ClockType
from rclpy.experimental import EventsExecutor

from hitab_ros.guarded_node import GuardedNode
from hitab_ros.testing import context_of_its_own, spin_until


class Process:
    """A node, and others where a test adds them, in a ROS domain of its own."""

    def __init__(self, node: GuardedNode, executor: EventsExecutor) -> None:
        self.node = node
        self._executor = executor
        self._nodes: list[GuardedNode] = []
        self.add(node)

    def add(self, node: GuardedNode) -> None:
        """Have another node in it; it is taken down at the end."""
        self._executor.add_node(node)
        self._nodes.append(node)

    def close(self) -> None:
        """End, as a process of the project does."""
        while self._nodes:
            node = self._nodes.pop()
            self._executor.remove_node(node)
            node.destroy_node()
        self._executor.shutdown()

    def until(self, condition: Callable[[], Any]) -> None:
        spin_until(self._executor, condition)

    def meanwhile(self, done: list[Any], seconds: float = 0.005) -> None:
        """Do something else, again and again."""
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.node.create_timer(seconds, lambda: done.append("something else"), clock=clock)


@pytest.fixture
def process() -> Iterator[Process]:
    with context_of_its_own() as context:
        node = GuardedNode("host", context=context)
        executor = EventsExecutor(context=context)
        with contextlib.closing(Process(node, executor)) as made:
            yield made
