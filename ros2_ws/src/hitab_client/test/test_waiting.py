"""Time in which a client could not run does not count as waiting, since others are late, too."""

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs import srv
from hitab_msgs.msg import AgentStatus

from hitab_client.connecting.ros_link import RosLink
from hitab_client.errors import SwarmError
from hitab_client.swarm_client import SwarmClient
from hitab_core.operations import Command, Perform, Test
from hitab_ros.busy_timeout import BUSY_FACTOR
from hitab_ros.call import Caller, blocking, refused


class Late(RosLink):
    """A client whose waits end late; no node is behind it."""

    def __init__(self, late: float) -> None:
        self.late = late

    def spin(self, seconds: float = 0.1) -> None:
        time.sleep(seconds + self.late)


def looks(link: RosLink, seconds: float, work: float = 0.0) -> int:
    """Return the number of checks of a condition in a time.

    Args:
        link: link to wait with.
        seconds: timeout.
        work: processor time of a check, s.
    """
    count = 0

    def never() -> bool:
        nonlocal count
        count += 1
        end = time.process_time() + work
        while time.process_time() < end:
            pass
        return False

    assert not link.spin_until(never, seconds, each=0.05)
    return count


def test_time_in_which_it_could_not_run_does_not_count():
    assert looks(Late(0.1), 0.2) >= 4  # in three times the time


def test_there_is_an_end_to_that():
    assert looks(Late(0.4 * BUSY_FACTOR), 0.2) == 2


def test_its_own_work_counts():
    assert looks(Late(0.0), 0.4, work=0.05) <= 5


class Link(Caller):
    """A link to an agent of a stepped world, with the requests and statuses on their way.

    Attributes:
        missing: agents that the world waits for, until something waits for them.
        sent: the requests, each with the missing agents of that time.
        answers: answers to come; an exception is raised.
    """

    def __init__(self, *answers: Any) -> None:
        self.missing: list[str] = []
        self.sent: list[tuple[Any, list[str]]] = []
        self.answers = list(answers)
        self.perceives: Callable[[], None] = lambda: None

    def will_call(self, kind: type, service: str) -> None:
        """No preparation is needed."""

    def subscribe(self, kind: type, topic: str, hear: Callable[[Any], None], *_: Any) -> None:
        if kind is AgentStatus:
            self.hear = hear

    @blocking
    async def call(self, kind: type, service: str, request: Any, **given: Any) -> Any:
        self.sent.append((request, list(self.missing)))
        answer = self.answers.pop(0)
        given["heard"](answer)
        if not answer.success:
            raise refused(answer)
        return answer

    async def until(self, done: Callable[[], Any], *_: Any, **more: Any) -> bool:
        if not done():
            self.missing.clear()
            self.perceives()
        return bool(done())


def status_of(sequence: int, process: int = 7, **fields: Any) -> AgentStatus:
    return AgentStatus(agent="keeper", process=process, sequence=sequence, **fields)


def client(link: Any) -> SwarmClient:
    """Return a client that has heard one status of its keeper."""
    swarm = SwarmClient(link, ["keeper"])
    link.hear(status_of(5, perceived=True))
    return swarm


def test_an_agent_that_is_late_in_a_stepped_world_is_commanded_once_it_is_back():
    link = Link(srv.Command.Response(success=True))
    link.missing.append("keeper")
    world: Any = SimpleNamespace(is_paused=True, missing=link.missing)
    client(link).do("keeper", Command("GoFast", by="ann"), world=world)
    assert [(request.by, missing) for request, missing in link.sent] == [("ann", [])]


def test_a_command_is_sent_again_to_an_agent_that_had_perceived_nothing_but_is_refused_once():
    blind = srv.Command.Response(message="nothing perceived yet", status=status_of(6))
    link = Link(blind, srv.Command.Response(success=True, message="done"))
    link.perceives = lambda: link.hear(status_of(7, perceived=True))
    swarm = client(link)
    assert swarm.do("keeper", Command("GoFast")).message == "done"
    assert [request.behavior for request, _ in link.sent] == ["GoFast"] * 2
    link.answers = [srv.Command.Response(message="no", status=status_of(8, perceived=True))]
    with pytest.raises(SwarmError, match="no"):
        swarm.do("keeper", Command("GoFast"))


def test_a_command_is_sent_again_if_the_agent_has_perceived_since_its_refusal():
    """The status on the topic may be faster than the refusal."""
    blind = srv.Command.Response(message="nothing perceived yet", status=status_of(4))
    link = Link(blind, srv.Command.Response(success=True, message="done"))
    assert client(link).do("keeper", Command("GoFast")).message == "done"
    (first, _), (second, _) = link.sent
    assert first is second  # with the id that the first call gave it


def test_waiting_for_a_percept_takes_no_longer_than_the_timeout():
    blind = srv.Command.Response(message="nothing perceived yet", status=status_of(6))
    link = Link(*[blind] * 2)
    with pytest.raises(SwarmError, match="nothing perceived yet"):
        client(link).do("keeper", Command("GoFast"))
    assert len(link.sent) == 1


def test_the_status_in_an_answer_is_not_replaced_by_an_older_one_from_the_topic():
    """The topic and the service are two connections, so that their messages may be reordered."""
    link = Link(srv.Test.Response(success=True, status=status_of(9, mode="testing")))
    swarm = client(link)
    assert swarm.do("keeper", Test()).success
    for older in (status_of(8, mode="training"), status_of(6, mode="idle")):
        link.hear(older)
        assert swarm.statuses["keeper"].mode == "testing"
    link.hear(status_of(10, mode="training"))
    assert swarm.statuses["keeper"].mode == "training"
    # An agent that was restarted counts from the beginning.
    link.hear(status_of(1, process=3, mode="idle"))
    assert swarm.statuses["keeper"].mode == "idle"


def test_the_status_in_a_refusal_counts_too():
    changed = status_of(9, mode="performing", last_error="no")
    link = Link(srv.Perform.Response(message="no", status=changed))
    swarm = client(link)
    with pytest.raises(SwarmError, match="no"):
        swarm.do("keeper", Perform("Dance"))
    assert swarm.statuses["keeper"] == changed
