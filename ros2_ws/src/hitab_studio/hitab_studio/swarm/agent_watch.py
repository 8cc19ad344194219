"""Watches the viewed agents: their percepts, decisions and learned behaviors.

A request costs the agent some time, so only the viewed agents are asked. `AgentState`, the state
for pages, is immutable and replaced as a whole.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from types import MappingProxyType
from typing import Any

from hitab_msgs.msg import TransitionEvent

from hitab_client import Learned, SwarmClient, SwarmError, Training
from hitab_core import FLAGS, START, Term
from hitab_core.operations import Command, Perform, TakeOver, Test, Undo
from hitab_ros.answering import what_went_wrong
from hitab_ros.call import blocking
from hitab_ros.timing import REFRESH_S, REPEAT_S
from hitab_studio.pages.example_effects import Effect, effect
from hitab_studio.swarm.received_vocabulary import NO_ITEMS, Vocabulary, terms

HISTORY_MAX = 120
"""Values of a feature kept for its curve."""

PROBED_MAX = 200
"""Features with targets that are read in one request."""

SHELF_MAX = 40
"""Trained behaviors read in advance, before a page shows them."""

FIRST_ASKED = (Command, Perform, TakeOver, Test, Undo)
"""Operations on an agent that is viewed, whose first key press waits for no discovery."""


@dataclass(frozen=True)
class AgentState:
    """The state of a viewed agent.

    Attributes:
        vocabulary: behaviors, features and targets of the agent.
        behaviors: the needed behaviors of the agent's library, by name.
        readings: the last values, oldest first, by automaton and feature: the features of the
            active automata, and under the automaton "" all features of the agent, while no
            automaton is active or a page probes them.
        transitions: the last state changes, newest last.
        change: effect of the last change of examples; None before the first change.
    """

    vocabulary: Vocabulary = field(default_factory=Vocabulary)
    behaviors: Mapping[str, Learned] = field(default_factory=lambda: NO_ITEMS)
    readings: Mapping[tuple[str, str], tuple[float, ...]] = field(default_factory=lambda: NO_ITEMS)
    transitions: tuple[TransitionEvent, ...] = ()
    change: Effect | None = None


class AgentWatch:
    """Listens to an agent and requests its state without blocking.

    Args:
        agents: client of the swarm's agents.
        agent: name of the agent.
        events: last state changes of the agent, newest last, updated by the caller.
        ask: sends a request to the swarm; see `SwarmLink.ask`.
        changed: called after the vocabulary, the training or a behavior has changed.
        failed: called with a message and the `error` if an answer is invalid.

    Attributes:
        known: the present state of the agent.
        training: the agent's training at the last look, if any.
        read: when features were read last, on the monotonic clock, s, and the agent's cycle then;
            None before.
    """

    def __init__(
        self,
        agents: SwarmClient,
        agent: str,
        events: Sequence[TransitionEvent],
        ask: Callable[..., Awaitable[Any]],
        changed: Callable[[], None],
        failed: Callable[..., None],
    ) -> None:
        self.known = AgentState()
        self.training: Training | None = None
        self.read: tuple[float, int] | None = None
        self._agents = agents
        self._agent = agent
        self._events = events
        self._call = ask
        self._changed = changed
        self._failed = failed
        self._asking: dict[str, asyncio.Task[None]] = {}
        self._next_read = 0.0
        self._digest = ""
        self._trained = ""
        self._wanted: set[str] = set()
        self._current: set[str] = set()  # behaviors read since the last change of the library
        self._probing = False
        agents.watch_training(agent)
        for kind in FIRST_ASKED:
            agents.will_do(agent, kind)

    def close(self) -> None:
        """Stop watching."""
        self._agents.forget_training(self._agent)

    def want(self, name: str) -> None:
        """Keep a behavior of the library up to date from now on."""
        self._wanted.add(name)

    def probe(self, *, on: bool) -> None:
        """Start or stop reading all features with all targets."""
        self._probing = on
        self._next_read = 0.0

    def look(self) -> None:
        """Take the current training, and request everything that may have changed."""
        status = self._agents.statuses.get(self._agent)
        if status is None:
            return
        if self.known.transitions[-1:] != tuple(self._events)[-1:]:
            self._know(transitions=tuple(self._events))
        # Saving an unchanged behavior changes its version and description, but not the digest.
        ended = bool(self._trained) and not status.training.automaton
        self._trained = status.training.automaton
        digest = status.library_digest
        if digest != self._digest or ended or not self.known.vocabulary.domain:
            self._digest = digest
            self._current.clear()
            self._ask("vocabulary", SwarmClient.vocabulary, self._take_vocabulary)
        self._take_training(
            self._agents.trainings.get(self._agent) if status.training.automaton else None
        )
        for name in self._needed(status) - self._current:
            self._ask(name, SwarmClient.behavior, partial(self._take_behavior, name), name)
        if (now := time.monotonic()) >= self._next_read:
            self._next_read = now + REFRESH_S
            words, also = self.known.vocabulary, []
            if self._probing or not status.active_path:
                also = [str(term) for _, term in terms(words.features, words.targets)]
            read = SwarmClient.read_features
            self._ask("features", read, self._take_features, also[:PROBED_MAX])

    def _needed(self, status: Any) -> set[str]:
        """Return the names of the trained and the active behaviors, and of their parts."""
        known, training, found = self.known, self.training, set(self._wanted)
        trained = training.name if training is not None else ""
        labels = [label for label in (status.behavior, *status.active_path) if label]
        labels += training.possible_states if training is not None else ()
        while labels:
            name = Term.parse(labels.pop()).name
            if name not in found | {*FLAGS, START, trained}:
                found.add(name)
                behavior = known.behaviors.get(name)
                labels += behavior.labels if behavior is not None else ()
        shelf = sorted(known.vocabulary.trained)[:SHELF_MAX]
        return found | {*shelf} - {trained}

    # -- asking -----------------------------------------------------------------------------

    def _ask(
        self, key: str, verb: blocking[Any, ..., Any], take: Callable[[Any], None], *given: Any
    ) -> None:
        """Call a verb of the client for the agent, unless the same request is pending."""
        agent = self._agent

        async def answer() -> None:
            try:
                take(await self._call(lambda it: verb.coroutine(it.agents, agent, *given), agent))
            except SwarmError:
                await asyncio.sleep(REPEAT_S)
            except Exception as error:  # an invalid answer must not end the watch
                why = what_went_wrong(error)
                problem = f"The answer of {agent} about {key} cannot be read: {why}"
                self._failed(problem, error=error)
            finally:
                del self._asking[key]

        if key not in self._asking:
            self._asking[key] = asyncio.get_running_loop().create_task(answer())

    # -- answers ----------------------------------------------------------------------------

    def _know(self, **changes: Any) -> None:
        self.known = replace(self.known, **changes)

    def _take_vocabulary(self, answer: Any) -> None:
        words = Vocabulary.of(answer)
        there = {Term.parse(label).name for label in words.behaviors}
        kept = {name: it for name, it in self.known.behaviors.items() if name in there}
        self._know(vocabulary=words, behaviors=MappingProxyType(kept))
        self._changed()

    def _take_training(self, after: Training | None) -> None:
        before, self.training = self.training, after
        if after is before:
            return
        change = None
        if before is not None and after is not None and before.name == after.name:
            same = before.examples == after.examples and before.features == after.features
            change = self.known.change if same else effect(before, after)
        self._know(change=change)
        self._changed()

    def _take_behavior(self, name: str, answer: Learned) -> None:
        self._current.add(name)
        self._know(behaviors=MappingProxyType({**self.known.behaviors, name: answer}))
        self._changed()

    def _take_features(self, answer: Any) -> None:
        self.read = time.monotonic(), answer.cycle
        before = self.known.readings
        readings = {}
        for read in answer.readings:
            past = before.get((read.automaton, read.feature), ())
            readings[read.automaton, read.feature] = (*past, read.value)[-HISTORY_MAX:]
        self._know(readings=MappingProxyType(readings))
