"""A call whose answer is lost succeeds all the same, and what it does is done once."""

import contextlib
import threading
from collections.abc import Iterator

import pytest
import rclpy
from hitab_msgs.srv import EditExamples
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.signals import SignalHandlerOptions

from hitab_client import domain_ids
from hitab_client.ros_link import RosLink
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
        self.done.append(getattr(request, "client", ""))
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
    # Without repeating, the call fails; without recognizing, the edit is made three times.
    with server(domain, EditExamples, lost=2) as there, RosLink(domain) as link:
        assert call(link, EditExamples).message == "done 1"
        assert there.asked == 3
        assert len(there.done) == 1
        assert call(link, EditExamples).message == "done 2"  # another request is another one


def sent_twice(link: RosLink, kind: type, service: str, **fields):
    """Send one numbered request twice, as after a lost answer, and return both answers."""
    request = kind.Request(request=77, client="a test", **fields)
    return [link.call(kind, service, request, missing=lambda: "it is not there") for _ in range(2)]


def test_an_agent_undoes_once_what_it_is_asked_twice_to_undo(keepers):
    keepers.agents.begin("keeper_1", "Twice", features=["Done"], discard=True)
    for behavior in ("GoFast", "GoSlow", "Stop"):
        keepers.agents.command("keeper_1", behavior)
    before = len(keepers.agents.training("keeper_1").examples)
    answers = sent_twice(
        keepers.link, EditExamples, "/keeper_1/edit_examples", action=EditExamples.Request.UNDO
    )
    assert answers[0].success
    assert answers[0] == answers[1]
    undone = before - len(keepers.agents.training("keeper_1").examples)
    assert undone == 2  # one command: its example and the default one
