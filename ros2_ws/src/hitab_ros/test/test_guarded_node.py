"""Nothing that a callback raises leaves it: it is logged once, shown, and forgotten when it ends.

Without the guard each of these exceptions leaves the executor, which ends a node's process.
"""

from __future__ import annotations

import functools
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hitab_msgs import msg, srv
from rcl_interfaces.msg import IntegerRange, ParameterDescriptor
from rclpy.context import Context
from rclpy.exceptions import InvalidParameterValueException, ParameterAlreadyDeclaredException
from rclpy.experimental import EventsExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message, serialize_message

from hitab_core.texts.errors import HitabError
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.testing import context_of_its_own, spin_until, wait_until


class Pair:
    """A node whose callbacks fail, with its log, and a node that sends to it."""

    def __init__(self, context: Context) -> None:
        self.node = GuardedNode("failing", context=context)
        self.peer = GuardedNode("peer", context=context)
        self.logged: list[str] = []
        self.node.guard.log = type(self.node.guard.log)(self.logged.append)
        self.executor = EventsExecutor(context=context)
        self.executor.add_node(self.node)
        self.executor.add_node(self.peer)

    @property
    def faults(self) -> list[str]:
        return self.node.guard.faults.texts()

    def until(self, condition: Callable[[], Any]) -> None:
        spin_until(self.executor, condition)

    def publisher(self, kind: Any, topic: str) -> Any:
        publisher = self.peer.create_publisher(kind, topic, 10)
        self.until(lambda: publisher.get_subscription_count() > 0)
        return publisher

    def ask(self, kind: Any, service: str, request: Any) -> Any:
        client = self.peer.create_client(kind, service)
        self.until(client.service_is_ready)
        future = client.call_async(request)
        self.until(future.done)
        return future.result()


@pytest.mark.parametrize("events", [True, False])
def test_whole_numbers_are_taken_for_the_floats_of_a_node_and_other_types_refused(events):
    given = {"rate": 20, "limits": [1, 2], "count": 3, "mode": "fast", "seed": -1}
    with context_of_its_own() as context:
        overrides = [Parameter(name, value=value) for name, value in given.items()]
        node = GuardedNode(
            "node",
            context=context,
            parameter_overrides=overrides,
            publish_parameter_events=events,
        )
        assert node.declare_parameter("rate", 5.0).value == 20.0
        assert list(node.declare_parameter("limits", [0.5, 0.5]).value) == [1.0, 2.0]
        assert type(node.declare_parameter("count", 1).value) is int
        with pytest.raises(HitabError, match='"mode" is the text "fast"; it must be such as 1'):
            node.declare_parameter("mode", 1.5)
        whole = ParameterDescriptor(integer_range=[IntegerRange(from_value=0, to_value=9)])
        with pytest.raises(InvalidParameterValueException, match=r"seed out of range.* value: -1"):
            node.declare_parameter("seed", 0, whole)
        names = Parameter.Type.STRING_ARRAY
        assert node.declare_parameter("names", names, ParameterDescriptor()).value is None
        assert node.has_parameter("count")
        assert node.get_parameter("count").value == 3
        assert not node.has_parameter("seed")
        with pytest.raises(ParameterAlreadyDeclaredException):
            node.declare_parameter("count", 1)
        node.destroy_node()


@pytest.fixture
def pair() -> Iterator[Pair]:
    with context_of_its_own() as context:
        pair = Pair(context)
        yield pair
        pair.executor.shutdown()
        pair.node.destroy_node()
        pair.peer.destroy_node()


def test_an_error_in_a_topics_callback_is_shown_until_the_callback_succeeds(pair: Pair) -> None:
    taken: list[str] = []

    def take(command: msg.Command) -> None:
        taken.append(command.behavior)
        if command.behavior == "bad":
            raise IndexError("list index out of range")

    pair.node.create_subscription(msg.Command, "command", take, 10)
    publisher = pair.publisher(msg.Command, "command")
    for _ in range(50):
        publisher.publish(msg.Command(behavior="bad"))
        pair.until(lambda: pair.faults)
        expected = len(taken)
        pair.until(lambda expected=expected: len(taken) >= expected)
    assert "topic command failed: IndexError in test_guarded_node.py" in pair.faults[0]
    publisher.publish(msg.Command(behavior="good"))
    pair.until(lambda: not pair.faults)
    # Its trace is written once, not for each message.
    assert len(pair.logged) == 1
    assert "Traceback" in pair.logged[0]


def test_a_message_that_is_too_large_is_dropped_before_it_is_read_and_one_that_is_none_too(
    pair: Pair,
) -> None:
    """Deserializing a list of objects would hold up a node a hundred times as long."""
    taken: list[int] = []
    pair.node.create_subscription(msg.WorldState, "state", lambda m: taken.append(m.cycle), 10)
    publisher = pair.publisher(msg.WorldState, "state")
    large = serialize_message(msg.WorldState(entities=200_000 * [msg.Entity()]))
    began = time.thread_time()
    deserialize_message(large, msg.WorldState)
    reading = time.thread_time() - began
    publisher.publish(large)
    began = time.thread_time()
    pair.until(lambda: pair.logged)
    assert time.thread_time() - began < reading / 3
    assert f"it has {len(large):,} bytes; the limit is 12,000,000" in pair.logged[0]
    publisher.publish(serialize_message(msg.WorldState())[:-30])  # no message of the type
    publisher.publish(msg.WorldState(cycle=3))
    pair.until(lambda: taken == [3])
    assert not pair.faults, "it is the sender's fault"


def test_an_error_in_a_timer_does_not_stop_it(pair: Pair) -> None:
    calls: list[int] = []

    def tick() -> None:
        calls.append(1)
        if len(calls) < 3:
            raise ZeroDivisionError

    pair.node.create_timer(0.01, functools.partial(tick))
    pair.until(lambda: len(calls) == 2)
    assert "tick failed: ZeroDivisionError" in pair.faults[0]
    pair.until(lambda: len(calls) > 2)
    assert not pair.faults


def test_a_service_that_raises_answers_with_the_reason_if_it_can(pair: Pair) -> None:
    errors = iter([IndexError("of nothing"), HitabError("it is missing")])

    def serve(request: Any, response: Any) -> Any:
        raise next(errors)

    def unsayable(request: Any, response: Any) -> Any:
        response.success, response.message = True, "\ud800"  # what UTF-8 has no bytes for
        return response

    pair.node.create_service(srv.Perform, "perform", unsayable)
    pair.node.create_service(srv.ReadFeatures, "read", serve)
    answer = pair.ask(srv.Perform, "perform", srv.Perform.Request())
    assert not answer.success
    assert "UnicodeEncodeError" in answer.message
    pair.node.guard.faults.clear("service perform")
    for why in ("of nothing", "it is missing"):
        answer = pair.ask(srv.ReadFeatures, "read", srv.ReadFeatures.Request())
        assert not answer.success
        assert why in answer.message
    # The caller's mistake is no fault of the node.
    assert len(pair.faults) == 1
    pair.node.create_service(srv.GetVocabulary, "vocabulary", lambda *_: {}["domain"])
    # It has no field for a reason.
    assert not pair.ask(srv.GetVocabulary, "vocabulary", srv.GetVocabulary.Request()).domain
    assert "service vocabulary failed: KeyError" in pair.faults[1]


def test_what_is_done_with_an_answer_is_guarded(pair: Pair) -> None:
    pair.peer.create_service(srv.Perform, "perform", lambda request, response: response)
    client = pair.node.create_client(srv.Perform, "perform")
    pair.until(client.service_is_ready)

    def take(future: Any) -> None:
        raise RuntimeError("the answer is not to my liking")

    client.call_async(srv.Perform.Request()).add_done_callback(take)
    pair.until(lambda: pair.faults)
    assert "answer of perform failed: RuntimeError" in pair.faults[0]


def test_different_errors_are_logged_at_a_bounded_rate(pair: Pair) -> None:
    for number in range(10_000):
        pair.node.guard.failed(f"topic number_{number}", HitabError("x" * 100_000))
    assert len(pair.logged) < 30
    assert sum(map(len, pair.logged)) < 100_000
    assert sum(map(len, pair.faults)) < 30_000


class Unspeakable(Exception):
    """A foreign error that cannot even be printed."""

    def __str__(self) -> str:
        raise ValueError("no")

    __repr__ = __str__


def test_the_guard_survives_errors_that_cannot_be_printed_and_a_status_that_fails(pair):
    pair.node.faults_changed = lambda: 1 / 0

    def take(command: msg.Command) -> None:
        raise Unspeakable

    pair.node.create_subscription(msg.Command, "command", take, 10)
    pair.publisher(msg.Command, "command").publish(msg.Command())
    pair.until(lambda: pair.faults)
    assert "topic command failed: Unspeakable" in pair.faults[0]


@pytest.mark.parametrize("subscribes", [True, False])
def test_what_is_temporary_is_destroyed_though_a_peer_does_not_match_it(pair, subscribes):
    # Otherwise the executor fails: the event that tells of the peer waits in its queue.
    profiles = [
        QoSProfile(depth=1, reliability=kind)
        for kind in (ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT)
    ]
    for number in range(10):
        topic = f"topic_{number}"
        if subscribes:
            end = pair.node.create_subscription(
                msg.Command, topic, print, profiles[0], temporary=True
            )
            other = functools.partial(pair.peer.create_publisher, msg.Command, topic)
        else:
            end = pair.node.create_publisher(msg.Command, topic, profiles[1], temporary=True)
            other = functools.partial(pair.peer.create_subscription, msg.Command, topic, print)
        pair.executor.spin_once(0.0)
        other(profiles[1] if subscribes else profiles[0])
        count = pair.node.count_publishers if subscribes else pair.node.count_subscribers
        wait_until(lambda topic=topic, count=count: count(topic))
        destroy = pair.node.destroy_subscription if subscribes else pair.node.destroy_publisher
        destroy(end)
        for _ in range(5):
            pair.executor.spin_once(0.0)


def test_what_is_not_temporary_is_destroyed_with_its_node_only(pair: Pair) -> None:
    heard = pair.node.create_subscription(msg.Command, "command", print, 10)
    sent = pair.node.create_publisher(msg.Command, "command", 10)
    with pytest.raises(ValueError, match="/command is destroyed before its node"):
        pair.node.destroy_subscription(heard)
    with pytest.raises(ValueError, match="/command is destroyed before its node"):
        pair.node.destroy_publisher(sent)
