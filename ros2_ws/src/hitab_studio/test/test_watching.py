"""What the studio asks the selected agent, and when it asks again."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from hitab_msgs.msg import AgentStatus

from hitab_studio.agent_watch import AgentWatch


class Node:
    """Stands for a node whose services note that they were called, and refuse."""

    def __init__(self) -> None:
        self.asked: list[str] = []

    def subscribe(self, *arguments: Any, temporary: bool) -> None:
        return None

    @property
    def node(self) -> Any:
        return self

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
        self.status = AgentStatus(mode=AgentStatus.IDLE, library_digest="one")
        self.node = Node()
        self.watch = AgentWatch(
            self.node,  # type: ignore[arg-type]
            "keeper_1",
            lambda: self.status,
            lambda: None,
            lambda *_: None,
        )
        known = self.watch.known
        self.watch.known = replace(known, vocabulary=replace(known.vocabulary, domain="keepaway"))
        self.look()

    def look(self, **changes: Any) -> bool:
        """Change the status; return whether the agent is then asked what it has learned."""
        for name, value in changes.items():
            setattr(self.status, name, value)
        self.node.asked.clear()
        self.watch.look()
        return "get_vocabulary" in self.node.asked


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
    assert not seen.look(mode=AgentStatus.TRAINING)
    assert not seen.look(examples=4)
    assert not seen.look(mode=AgentStatus.PERFORMING)
    assert seen.look(examples=0)
