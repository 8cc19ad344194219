"""Time in which a client could not run does not count as waiting, since others are late, too."""

import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus, Command
from hitab_msgs.srv import BeginTraining, EditExamples, Perform, SaveBehavior, SetMode

from hitab_client.ros_link import RosLink
from hitab_client.swarm_client import SwarmClient
from hitab_core.operations import BeginTraining, Command, Perform, SaveBehavior, Test, Undo
from hitab_ros.busy_timeout import BUSY_FACTOR
from hitab_ros.call import Caller, blocking


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


class Keeper(Caller):
    """A link to a swarm whose keeper has missed a cycle of a stepped world, and comes back."""

    def __init__(self) -> None:
        self.world = SimpleNamespace(is_paused=True, missing=["keeper"])
        self.missed: list[list[str]] = []
        self.node = SimpleNamespace(create_publisher=lambda *_: self)

    def subscribe(self, *arguments: Any) -> None:
        pass

    def get_subscription_count(self) -> int:
        return 1

    def publish(self, command: Command) -> None:
        self.missed.append(list(self.world.missing))
        self.status.last_command_sequence = command.sequence

    async def until(self, done: Callable[[], Any], *_: Any, **more: Any) -> bool:
        if not done():
            self.world.missing.clear()
        return bool(done())


def test_an_agent_that_is_late_in_a_stepped_world_is_commanded_once_it_is_back():
    link: Any = Keeper()
    swarm = SwarmClient(link, ["keeper"])
    link.status = swarm.statuses["keeper"] = AgentStatus(agent="keeper")
    swarm.do("keeper", Command("GoFast"), world=link.world)
    assert link.missed == [[]]


class Slow(Caller):
    """A link to an agent whose statuses come seconds after its answers."""

    def __init__(self, answer: Any, *statuses: AgentStatus, seconds: float = 3.0) -> None:
        self.answer = answer
        self.on_the_way = list(statuses)
        self._seconds = seconds

    def subscribe(self, *arguments: Any) -> None:
        pass

    @blocking
    async def call(self, *_: Any, **__: Any) -> Any:
        return self.answer

    async def until(self, done: Callable[[], Any], seconds: float, *_: Any, **more: Any) -> bool:
        while not done() and seconds >= self._seconds and self.on_the_way:
            self.swarm.statuses["keeper"] = self.on_the_way.pop(0)
        return bool(done())


def of(mode: str, training: str, revision: int) -> AgentStatus:
    return AgentStatus(agent="keeper", mode=mode, training=training, training_revision=revision)


@pytest.mark.parametrize(
    ("ask", "answer", "before", "after"),
    [
        (
            lambda swarm: swarm.do("keeper", BeginTraining("Chase")),
            BeginTraining.Response(success=True, revision=7),
            of("idle", "", 0),
            of("training", "Chase", 7),
        ),
        (
            lambda swarm: swarm.do("keeper", Test()),
            SetMode.Response(success=True, revision=8),
            of("training", "Chase", 7),
            of("testing", "Chase", 8),
        ),
        (
            lambda swarm: swarm.do("keeper", Undo()),
            EditExamples.Response(success=True, revision=9),
            of("training", "Chase", 8),
            of("training", "Chase", 9),
        ),
        (
            lambda swarm: swarm.do("keeper", Perform()),
            Perform.Response(success=True),
            of("testing", "Chase", 9),
            of("idle", "Chase", 10),
        ),
        (
            lambda swarm: swarm.do("keeper", SaveBehavior()),
            SaveBehavior.Response(success=True),
            of("testing", "Chase", 9),
            of("performing", "", 0),
        ),
    ],
    ids=["begin", "test", "undo", "perform", "save"],
)
def test_who_has_an_answer_knows_the_agent_as_it_is_since_then(ask, answer, before, after):
    link: Any = Slow(answer, before, after)
    link.swarm = swarm = SwarmClient(link, ["keeper"])
    swarm.statuses["keeper"] = before
    ask(swarm)
    assert swarm.statuses["keeper"] == after
