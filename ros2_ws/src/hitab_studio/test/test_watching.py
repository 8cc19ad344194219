"""Requests of the studio to the viewed agent, and their repetition."""

import asyncio
from collections.abc import Awaitable, Callable
from types import SimpleNamespace
from typing import Any

from hitab_msgs.msg import AgentStatus, TrainingStatus
from hitab_msgs.srv import GetVocabulary

from hitab_studio.swarm.agent_watch import AgentWatch


class Agents:
    """A stand-in for a swarm's client that records requests."""

    prefix = ""

    def __init__(self) -> None:
        self.link = SimpleNamespace(subscribe=lambda *_, **__: None)
        self.statuses = {"ann": AgentStatus(mode=AgentStatus.IDLE, library_digest="one")}
        self.trainings: dict[str, Any] = {}
        self.watch_training = lambda agent: None
        self.prepared: list[str] = []
        self.will_do = lambda agent, kind: self.prepared.append(kind.name)


class Seen:
    """An agent with a status, and the requests that the studio sends in response."""

    def __init__(self) -> None:
        self.agents: Any = Agents()
        self.asked = 0
        self.watch = AgentWatch(
            self.agents, "ann", [], self.ask, lambda: None, lambda *_, **__: None
        )

    async def ask(self, what: Callable[[Any], Any], needs: str) -> Any:
        async def ask(agent: str, kind: Any, *_: Any, **__: Any) -> Any:
            self.asked += kind is GetVocabulary
            return GetVocabulary.Response(domain="keepaway")

        self.agents.ask = SimpleNamespace(coroutine=ask)
        return await what(SimpleNamespace(agents=self.agents))

    async def look(self, **changes: Any) -> bool:
        """Change the status; return whether the studio then requests the learned behavior."""
        for name, value in changes.items():
            setattr(self.agents.statuses["ann"], name, value)
        self.asked = 0
        self.watch.look()
        await asyncio.sleep(0)
        return self.asked > 0


def seen(term: Callable[[Seen], Awaitable[None]]) -> None:
    async def run() -> None:
        agent = Seen()
        assert await agent.look()
        await term(agent)

    asyncio.run(run())


def test_what_was_learned_is_asked_for_when_the_digest_changes():
    async def term(agent: Seen) -> None:
        assert not await agent.look()
        assert not await agent.look(mode=AgentStatus.PERFORMING)
        assert await agent.look(library_digest="two")
        assert not await agent.look()

    seen(term)


def test_a_behavior_that_is_saved_again_as_it_was_is_asked_for():
    """The digest is the same, but version and description may differ."""

    async def term(agent: Seen) -> None:
        chase = TrainingStatus(automaton="Chase")
        assert not await agent.look(mode=AgentStatus.TRAINING, training=chase)
        assert not await agent.look(mode=AgentStatus.PERFORMING)
        assert await agent.look(training=TrainingStatus())

    seen(term)


def test_the_first_key_press_at_an_agent_waits_for_no_discovery():
    async def term(agent: Seen) -> None:
        assert {"command", "take_over", "test", "undo"} <= {*agent.agents.prepared}

    seen(term)
