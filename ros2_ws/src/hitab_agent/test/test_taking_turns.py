"""What a host does for many agents is done in turns, and what many need is heard once."""

import contextlib
import os
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import rclpy
from domain_coordinator import domain_id
from hitab_msgs import msg
from rclpy.clock import Clock, ClockType
from rclpy.context import Context
from rclpy.experimental import EventsExecutor
from rclpy.node import Node

from hitab_agent.later import Later
from hitab_agent.order_desk import OrderDesk
from hitab_agent.ticker import Ticker
from hitab_ros import names, qos

SECONDS = 20.0


class Process:
    """One node in a ROS domain of its own."""

    def __init__(self, node: Node, executor: EventsExecutor) -> None:
        self.node = node
        self._executor = executor

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
        executor.add_node(node)
        stack.callback(executor.shutdown)
        stack.callback(node.destroy_node)
        yield Process(node, executor)


def test_what_is_put_off_is_done_in_order_with_room_for_something_else_in_between(process):
    done: list[Any] = []
    later = Later(process.node, 0.02, at_most=10)
    for number in range(40):
        later.call(lambda number=number: done.append(number))
    process.meanwhile(done)
    process.until(lambda: 39 in done)
    assert [what for what in done if what != "something else"] == list(range(40))
    for turn in range(3):
        last, first = done.index(10 * turn + 9), done.index(10 * turn + 10)
        assert "something else" in done[last:first]


def test_what_is_put_off_without_a_limit_is_done_together_and_again_when_more_comes(process):
    done: list[Any] = []
    later = Later(process.node, 0.02)
    process.meanwhile(done)
    for again in (1, 2):
        for number in range(40):
            later.call(lambda number=number: done.append(number))
        process.until(lambda again=again: done.count(39) == again)
        first = len(done) - 1 - done[::-1].index(0)
        assert done[first : first + 40] == list(range(40))


def test_many_functions_of_one_rate_are_called_equally_often_in_turns(process):
    done: list[Any] = []
    ticker = Ticker(process.node)
    for number in range(50):
        ticker.every(0.2, lambda number=number: done.append(number))
    process.meanwhile(done)
    process.until(lambda: done.count(49) == 4)
    counts = Counter(done)
    assert {counts[number] for number in range(50)} <= {3, 4, 5}
    assert "something else" in done[done.index(10) : done.index(40)]


def test_functions_of_different_rates_are_called_at_their_own(process):
    done: list[str] = []
    ticker = Ticker(process.node)
    ticker.every(0.3, lambda: done.append("seldom"))
    ticker.every(0.03, lambda: done.append("often"))
    process.until(lambda: done.count("seldom") == 3)
    assert done.count("often") > 3 * done.count("seldom")


def test_all_who_are_under_a_commander_hear_it_through_one_subscription(process):
    node = process.node
    publisher = node.create_publisher(msg.Order, f"/chief/{names.ORDER}", qos.LATCHED)
    desk, heard = OrderDesk(node), []
    before = len(list(node.subscriptions))
    for who in ("a", "b"):
        desk.listen(node, "chief", lambda order, who=who: heard.append((who, order.name)))
    assert len(list(node.subscriptions)) == before + 1
    publisher.publish(msg.Order(commander="chief", epoch=1, sequence=1, order="Attack"))
    process.until(lambda: len(heard) == 2)
    assert heard == [("a", "Attack"), ("b", "Attack")]
    desk.listen(node, "chief", lambda order: heard.append(("late", order.name)))
    assert heard[-1] == ("late", "Attack")
