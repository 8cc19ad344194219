"""What the studio asks the selected agent, and when it asks again."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus

from hitab_studio.agent_watch import AgentWatch


class Agents:
    """Stands for a swarm's client whose services note that they were called, and refuse."""

    prefix = ""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.link = self.node = self
        self.statuses = {"ann": AgentStatus(mode=AgentStatus.IDLE, library_digest="one")}
        self.trainings: dict[str, Any] = {}

    def watch_training(self, agent: str) -> None:
        pass

    def subscribe(self, *arguments: Any, temporary: bool) -> None:
        pass

    def create_client(self, kind: Any, name: str) -> Any:
        def call(request: Any) -> Any:
            self.asked.append(name.rpartition("/")[2])
            future = SimpleNamespace(result=lambda: SimpleNamespace(success=False))
            future.add_done_callback = lambda take: take(future)
            return future

        return SimpleNamespace(service_is_ready=lambda: True, call_async=call)


class Seen:
    """An agent as the studio sees it: its status, and what it is asked because of it."""

    def __init__(self) -> None:
        self.agents = Agents()
        agents: Any = self.agents
        self.watch = AgentWatch(agents, "ann", lambda: None, lambda *_, **__: None)
        known = self.watch.known
        self.watch.known = replace(known, vocabulary=replace(known.vocabulary, domain="keepaway"))
        self.look()

    def look(self, **changes: Any) -> bool:
        """Change the status; return whether the agent is then asked what it has learned."""
        for name, value in changes.items():
            setattr(self.agents.statuses["ann"], name, value)
        self.agents.asked.clear()
        self.watch.look()
        return "get_vocabulary" in self.agents.asked


@pytest.fixture
def seen() -> Seen:
    return Seen()


def test_nothing_new_is_not_asked_for_again(seen):
    assert not seen.look()
    assert not seen.look(mode=AgentStatus.PERFORMING)


def test_what_was_learned_is_asked_for_when_the_digest_changes_or_something_was_distributed(seen):
    assert seen.look(library_digest="two")
    assert seen.look(distribution=5)
    assert not seen.look()


def test_a_behavior_that_is_saved_again_as_it_was_is_asked_for(seen):
    # Its digest is the same, but its version and description may not be.
    assert not seen.look(mode=AgentStatus.TRAINING, training="Chase")
    assert not seen.look(mode=AgentStatus.PERFORMING)
    assert seen.look(training="")
