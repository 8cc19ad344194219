"""A call whose answer is lost succeeds all the same, and what it does is done once."""

import contextlib
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import rclpy
from hitab_msgs.srv import Control
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from hitab_client import domain_ids
from hitab_client.connecting.ros_link import RosLink
from hitab_client.swarm_client import SwarmClient
from hitab_core.operations import (
    BeginTraining,
    Command,
    DiscardTraining,
    SaveBehavior,
    Undo,
)
from hitab_ros.answering import answering


class Server:
    """A node with a service that counts, in a thread of its own; some of its answers are lost."""

    def __init__(self, context: Context, kind: type, lost: int) -> None:
        self.done: list[str] = []
        self.asked = 0
        self._lost = lost
        self._node = rclpy.create_node("server", context=context)
        self._service = self._node.create_service(kind, "/it", answering(self._serve))
        self._send = self._service.send_response
        self._service.send_response = self._send_some
        self._executor = SingleThreadedExecutor(context=context)
        self._executor.add_node(self._node)
        self._thread = threading.Thread(target=self._executor.spin)
        self._thread.start()

    def _serve(self, request, response) -> str:
        self.done.append(request.id)
        return f"done {len(self.done)}"

    def _send_some(self, response, header) -> None:
        self.asked += 1
        if self.asked > self._lost:
            self._send(response, header)

    def close(self) -> None:
        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()


@pytest.fixture
def domain(monkeypatch) -> Iterator[int]:
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    with domain_ids.reserved() as number:
        yield number


@contextlib.contextmanager
def server(domain: int, kind: type, lost: int) -> Iterator[Server]:
    context = Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    with contextlib.closing(Server(context, kind, lost)) as made:
        yield made
    context.try_shutdown()


def call(link: RosLink, kind: type, seconds: float = 30.0):
    return link.call(
        kind, "/it", kind.Request(), missing=lambda: "it is not there", seconds=seconds
    )


def test_an_answer_that_is_lost_is_asked_for_again_and_nothing_is_done_twice(domain):
    # Without repeating, the call fails; without recognizing, the world is driven three times.
    with server(domain, Control, lost=2) as there, RosLink(domain) as link:
        assert call(link, Control).message == "done 1"
        assert there.asked == 3
        assert len(there.done) == 1
        assert there.done[0], "a client gives each request an id"
        assert call(link, Control).message == "done 2"  # another request is another one


class Lossy:
    """A client of a service that does not get the first answers to each request."""

    def __init__(self, client: Any, lost: int) -> None:
        self._client, self._lost = client, lost
        self.sent: dict[str, int] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self._client, name)

    def call_async(self, request: Any) -> Any:
        answer = self._client.call_async(request)
        self.sent[request.id] = self.sent.get(request.id, 0) + 1
        return Future() if self.sent[request.id] <= self._lost else answer


ONE = "keeper_1"


def test_an_operation_whose_first_answers_are_lost_is_done_once_and_answered_as_it_was(
    keepers, monkeypatch
):
    keepers.agents.do(ONE, BeginTraining("Twice", features=["Done"], discard=True))
    lossy: list[Lossy] = []

    def create_client(*arguments: Any) -> Lossy:
        lossy.append(Lossy(make(*arguments), lost=2))
        return lossy[-1]

    with RosLink(keepers.record.domain_id) as link:
        make = link.node.create_client
        monkeypatch.setattr(link.node, "create_client", create_client)
        agents = SwarmClient(link, [ONE])
        answer = agents.do(ONE, Command("GoFast"))
        assert (list(answer.examples), answer.left) == ([1, 2], "Start")
        assert answer.status.training.examples == 2
        answer = agents.do(ONE, Command("Stop"))
        assert (list(answer.examples), answer.left) == ([3, 4], "GoFast")
        answer = agents.do(ONE, Undo())
        assert answer.message.startswith("undone: GoFast → Stop, 2 examples")
        assert answer.message.endswith('"Twice" has 2 examples')
        saved = agents.do(ONE, SaveBehavior())
        assert saved.message == 'saved "Twice" with 2 examples'
        assert Path(saved.path).exists()
        assert saved.replaced == ""
        agents.do(ONE, BeginTraining("Thrice", features=["Done"]))
        answer = agents.do(ONE, DiscardTraining())
        assert answer.message == f'{ONE} is idle; discarded "Thrice", which had no examples'
    sent = [number for client in lossy for number in client.sent.values()]
    assert len(sent) == 6
    assert set(sent) == {3}, "each was asked for three times"
