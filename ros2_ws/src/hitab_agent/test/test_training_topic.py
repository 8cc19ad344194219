"""What an agent is being trained is published while anybody subscribes, whole and in time."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hitab_msgs import msg

from hitab_agent.scheduler import Scheduler
from hitab_agent.topics.training_topic import TrainingTopic
from hitab_core import Agent, BehaviorLibrary, Term, plain_domain
from hitab_core.training import Curriculum
from hitab_ros import names, qos
from hitab_ros.messages.conversions import pairs_of

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position", "Speed"])


class Trained:
    """An agent that publishes what it is being trained on the node of a process."""

    def __init__(self, process: Any, folder: Path) -> None:
        self.process = process
        self.came: list[msg.Training] = []
        self.agent = Agent("ann", CART, BehaviorLibrary(folder / "library", CART), folder)
        self.topic = TrainingTopic(process.node, self.agent, Scheduler(process.node))
        self.topic.topic.open()

    def begin(self) -> Any:
        self.agent.begin(Curriculum("Shuttle", (Term("Position"), Term("Speed"))))
        self.show((0.0, "Right"), (5.0, "Left"), (0.0, "Right"), (5.0, "Right"))
        return self.agent.session

    def show(self, *commands: tuple[float, str]) -> None:
        for position, behavior in commands:
            self.sense(position)
            self.agent.command(Term(behavior))
            self.agent.tick()

    def sense(self, position: float) -> None:
        cycle = self.agent.cycle + 1
        self.agent.sense([position, position**2], [], cycle, cycle * 0.1)

    def subscribe(self) -> None:
        self.process.node.create_subscription(
            msg.Training, names.TRAINING, self.came.append, qos.LATCHED
        )

    def until(self, condition: Any) -> msg.Training:
        self.process.until(lambda: self.came and condition(self.came[-1]))
        return self.came[-1]


@pytest.fixture
def trained(process: Any, tmp_path: Path) -> Trained:
    return Trained(process, tmp_path)


def test_who_subscribes_gets_the_training_as_it_is_then_each_revision_and_its_end(
    trained: Trained,
) -> None:
    session = trained.begin()
    trained.topic.look()
    first = trained.topic.revision
    trained.subscribe()
    now = trained.until(lambda it: it.revision == first)
    assert [e.next_state for e in now.automaton.examples] == [
        e.next_state for e in session.examples
    ]
    assert {tree.state for tree in now.automaton.trees} == {"Start", "Left", "Right"}
    session.undo()
    undone = trained.until(lambda it: it.revision > first)
    assert len(undone.automaton.examples) < len(now.automaton.examples)
    assert len(undone.undone) == 1
    trained.agent.discard()
    assert trained.until(lambda it: not it.automaton.name).revision > undone.revision
    assert trained.topic.revision == 0


def test_who_decides_is_another_revision_of_which_the_questions_are_known(
    trained: Trained,
) -> None:
    trained.begin()
    trained.subscribe()
    trained.until(lambda it: it.searched)
    for change in (
        trained.agent.test,
        trained.agent.take_over,
        lambda: trained.agent.perform(None),
    ):
        before = trained.came[-1].revision
        change()
        assert trained.topic.notice() > before
        assert trained.until(lambda it, before=before: it.revision > before).searched


def test_a_loop_in_what_was_learned_is_published_with_what_would_mend_it(
    trained: Trained,
) -> None:
    trained.agent.begin(Curriculum("Shuttle", (Term("Position"), Term("Speed"))))
    trained.show((0.0, "Right"), (5.0, "Left"), (5.0, "Right"))
    trained.subscribe()
    (remark,) = trained.until(lambda it: it.remarks).remarks
    assert remark.code == "LOOP"
    assert dict(pairs_of(remark.arguments))["states"] == "Right and Left"
    assert remark.remedy.code == "RELABEL"


def test_nothing_is_built_while_nobody_subscribes(
    trained: Trained, monkeypatch: pytest.MonkeyPatch
) -> None:
    built: list[str] = []
    monkeypatch.setattr(
        "hitab_agent.topics.training_topic.training_message", lambda *_: built.append("built")
    )
    trained.begin()
    done: list[str] = []
    trained.process.meanwhile(done, 0.1)
    trained.process.until(lambda: len(done) > 3)
    assert trained.topic.revision > 0
    assert not built


def test_other_things_are_done_while_questions_are_looked_for(
    trained: Trained, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, done, found = trained.begin(), [], []
    trained.sense(3.0)  # nothing like it was shown
    trained.agent.tick()
    search = session.search

    def slow() -> Any:
        while len(done) < 3:
            yield None
        yield from search()

    monkeypatch.setattr(session, "search", slow)
    trained.topic.searched = lambda: found.append(len(session.questions.find()))
    trained.subscribe()
    trained.until(lambda it: it.automaton.name)
    trained.process.meanwhile(done)
    asked = trained.until(lambda it: it.searched)
    assert [q.kind for q in asked.questions] == ["contradiction", "unshown"]
    assert [choice.name for choice in asked.questions[0].choices] == ["Right", "Left"]
    assert found == [2]


def test_examples_that_change_during_the_search_are_asked_about(
    trained: Trained, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, searches = trained.begin(), []
    search = session.search

    def interrupted() -> Any:
        searches.append(len(session.examples))
        if len(searches) == 1:
            trained.show((7.0, "Left"), (0.0, "Right"), (7.0, "Right"))
        yield from search()

    monkeypatch.setattr(session, "search", interrupted)
    trained.subscribe()
    asked = trained.until(lambda it: it.searched)
    assert len(searches) == 2
    assert [q.kind for q in asked.questions].count("contradiction") == 2
