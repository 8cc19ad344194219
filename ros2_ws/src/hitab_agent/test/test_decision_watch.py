"""Decisions far from all examples are noticed by an observer that changes nothing."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from hitab_agent.topics import decision_watch
from hitab_agent.topics.decision_watch import LOOKS, DecisionWatch
from hitab_core import FAR, Agent, RatedFunctions, Term, decided_at
from hitab_core.automaton import Automaton
from hitab_core.domain import BasicBehavior, Domain, Feature, Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.learning.transition_learning import learn_transitions
from hitab_core.library.behavior_library import BehaviorLibrary


class Body:
    """A body that perceives one number, and counts how often that is read."""

    def __init__(self, name: str) -> None:
        self.value = 0.0
        self.reads = 0

    def sense(self, values: Any, heard: Any) -> None:
        self.value = values[0]

    def act(self) -> Any:
        return (), ""

    def read(self) -> float:
        self.reads += 1
        return self.value


def agent_with(tmp_path: Path) -> Agent:
    """Return an agent whose automaton was shown at 0, 1 and 2: go at less than 1.5, else stay."""
    shown = tuple(
        Example(state, (value,), "Go" if value < 1.5 else "Stay", ExampleKind.DEMONSTRATED)
        for state in ("Start", "Go", "Stay")
        for value in (0.0, 1.0, 2.0)
    )
    learned = learn_transitions(shown, [Scale()])
    domain = Domain.of(
        "numbers",
        "1",
        Body,
        behaviors=[BasicBehavior("Go", lambda body: None), BasicBehavior("Stay")],
        features=[Feature("X", Body.read)],
        automata=[
            Automaton("Learned", (Term("Go"), Term("Stay")), (Term("X"),), learned, examples=shown)
        ],
    )
    agent = Agent("one", domain, BehaviorLibrary(tmp_path, domain))
    agent.perform(Term("Learned"))
    return agent


def decide(agent: Agent, value: float) -> None:
    agent.sense([value], [])
    agent.tick()
    agent.sense([value], [])
    agent.tick()  # the second in the state that the first has entered


def test_what_was_decided_is_measured_without_reading_or_drawing_anything(tmp_path):
    agent = agent_with(tmp_path)
    for value, distance in ((0.0, 0.0), (1.0, 0.0), (12.0, 10.0), (-5.0, 5.0)):
        decide(agent, value)
        before = agent.body.reads, agent.draws, agent.active_path
        assert decided_at(agent.running, agent.domain, RatedFunctions()) == pytest.approx(distance)
        assert (agent.body.reads, agent.draws, agent.active_path) == before
    assert decided_at(None, agent.domain, RatedFunctions()) == 0.0


class Watched:
    """An agent's node as far as it is watched."""

    def __init__(self, agent: Agent) -> None:
        self.agent, self.agent_name = agent, agent.name
        self.published: list[float] = []
        self.failed: list[str] = []
        self.status = SimpleNamespace(
            decided_at=0.0, is_read=True, publish_soon=lambda: self.published.append(self.at)
        )
        self.guard = SimpleNamespace(run=self._run)

    @property
    def at(self) -> float:
        return self.status.decided_at

    def _run(self, key: str, call: Any, *arguments: Any) -> None:
        try:
            call(*arguments)
        except Exception:
            self.failed.append(key)


def watch_of(*nodes: Watched) -> Any:
    """Return what makes all agents have their turn."""
    looks: list[Any] = []
    scheduler = SimpleNamespace(every=lambda seconds, look: looks.append(look))
    DecisionWatch(nodes, scheduler)  # type: ignore[arg-type]
    return lambda: [looks[0]() for _ in range(LOOKS)]


def test_a_status_is_published_only_when_decisions_become_far_or_near_again(tmp_path):
    node = Watched(agent_with(tmp_path))
    look = watch_of(node)
    for value, published in ((0.0, 0), (90.0, 0), (91.0, 1), (95.0, 1), (0.0, 1), (1.0, 2)):
        decide(node.agent, value)
        look()
        assert len(node.published) == published, value
    assert node.published[0] > FAR
    assert node.published[1] == 0.0


def test_of_whom_nobody_reads_the_status_nothing_is_measured(tmp_path):
    node = Watched(agent_with(tmp_path))
    node.status.is_read = False
    look = watch_of(node)
    for _ in range(3):
        decide(node.agent, 90.0)
        look()
    assert node.published == []


def test_a_failure_is_shown_by_its_agent_and_the_others_are_watched(tmp_path, monkeypatch):
    good, bad = Watched(agent_with(tmp_path / "a")), Watched(agent_with(tmp_path / "b"))
    measure = decision_watch.decided_at

    def measured(running: Any, domain: Any, rated: Any) -> float:
        if domain is bad.agent.domain:
            raise ValueError
        return measure(running, domain, rated)

    monkeypatch.setattr(decision_watch, "decided_at", measured)
    look = watch_of(bad, good)
    for _ in range(2):
        decide(good.agent, 90.0)
        look()
    assert len(bad.failed) == 2
    assert len(good.published) == 1
