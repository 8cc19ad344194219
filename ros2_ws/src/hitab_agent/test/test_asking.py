"""An agent looks for questions in slices: its cycles, and commands, get their turn meanwhile."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hitab_msgs.srv import ListQuestions

from hitab_agent.question_services import QuestionServices
from hitab_agent.slices import Slices
from hitab_core import Agent, BehaviorLibrary, Use, plain_domain
from hitab_core.training import Curriculum

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position", "Speed"])


class Asking:
    """An agent in training that offers the services on the node of a process."""

    def __init__(self, process: Any, folder: Path) -> None:
        self.process = process
        self.told: list[str] = []
        self.agent = Agent("ann", CART, BehaviorLibrary(folder / "library", CART), folder)
        node = process.node
        QuestionServices(node, self.agent, self.told.append, Slices(node))
        self._client = node.create_client(ListQuestions, "list_questions")
        process.until(self._client.service_is_ready)

    def show(self, *commands: tuple[float, str]) -> None:
        for position, behavior in commands:
            cycle = self.agent.cycle + 1
            self.agent.sense([position, position**2], [], cycle, cycle * 0.1)
            self.agent.command(Use(behavior))
            self.agent.tick()

    def ask(self) -> Any:
        return self._client.call_async(ListQuestions.Request())

    def answer(self, asked: Any) -> Any:
        self.process.until(asked.done)
        return asked.result()


@pytest.fixture
def asking(process: Any, tmp_path: Path) -> Asking:
    return Asking(process, tmp_path)


def begun(asking: Asking) -> Asking:
    asking.agent.begin(Curriculum("Shuttle", (Use("Position"), Use("Speed"))))
    asking.show((0.0, "Right"), (5.0, "Left"), (0.0, "Right"), (5.0, "Right"))
    return asking


def test_other_things_are_done_between_the_steps_of_a_search(
    asking: Asking, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(asking)
    session = asking.agent.session
    assert session is not None
    done: list[str] = []
    steps = 0

    def search() -> Any:
        """Take as many steps as it takes for something else to be done in between."""
        nonlocal steps
        while len(done) < 3:
            steps += 1
            yield None

    monkeypatch.setattr(session, "search", search)
    asking.process.meanwhile(done)
    answer = asking.answer(asking.ask())
    assert steps > 3
    assert (answer.success, answer.message) == (True, "1 question")
    assert asking.told == [None]


def test_examples_that_change_during_the_search_are_asked_about(
    asking: Asking, monkeypatch: pytest.MonkeyPatch
) -> None:
    begun(asking)
    session = asking.agent.session
    assert session is not None
    searches = 0
    search = session.search

    def interrupted() -> Any:
        nonlocal searches
        searches += 1
        if searches == 1:
            asking.show((7.0, "Left"), (0.0, "Right"), (7.0, "Right"))
        yield from search()

    monkeypatch.setattr(session, "search", interrupted)
    answer = asking.answer(asking.ask())
    contradictions = [q for q in answer.questions if q.kind == "contradiction"]
    assert searches == 2
    assert len(contradictions) == 2


def test_several_who_ask_at_once_get_the_same_answer(asking: Asking) -> None:
    begun(asking)
    asked = [asking.ask() for _ in range(3)]
    answers = [asking.answer(one) for one in asked]
    assert answers[0].questions
    assert answers[0] == answers[1] == answers[2]


def test_without_a_training_and_when_it_ends_meanwhile_the_reply_says_so(
    asking: Asking, monkeypatch: pytest.MonkeyPatch
) -> None:
    answer = asking.answer(asking.ask())
    assert not answer.success
    assert answer.message == "it is not training anything"
    assert [remedy.code for remedy in answer.remedies] == ["RESUME", "TRAIN"]
    begun(asking)
    session = asking.agent.session
    assert session is not None

    def ends() -> Any:
        yield None
        asking.agent.discard()

    monkeypatch.setattr(session, "search", ends)
    answer = asking.answer(asking.ask())
    assert not answer.success
    assert answer.message == "it is not training anything"
