"""What is known of the viewed agents: what they perceive, decide and have learned.

Requests cost an agent a little, so only the viewed agents are asked, each by name. Everything
here runs in the thread of the link; what pages read of it, `Watched`, is replaced as a whole and
never changed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from hitab_msgs.msg import AgentStatus, Question, TransitionEvent
from hitab_msgs.srv import (
    GetBehavior,
    GetReport,
    GetVocabulary,
    ListExamples,
    ListQuestions,
    ReadFeatures,
)

from hitab_client import Learned, RosLink, learned_of
from hitab_core import FLAGS, START, Use
from hitab_core.training import TrainingCost
from hitab_ros import names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.conversions import costs_of
from hitab_studio.learned import (
    NOTHING,
    Effect,
    Vocabulary,
    effect,
    uses,
)

HISTORY = 120
"""Number of values of a feature that are kept for its curve."""

EVENTS = 60
"""Number of state changes that are kept."""

PROBED_MAX = 200
"""Features with targets whose values are asked for at once."""

SHELF_MAX = 40
"""Trained behaviors that are asked for before anybody looks at them."""

CALM_SECONDS = 1.0
"""After a change of examples until questions are asked for: the agent thinks about them."""

READ_SECONDS = 0.15
REFRESH_SECONDS = 2.0
COST_SECONDS = 30.0
"""Until the cost of a training that goes on is asked for again: the agent reads its journal."""

PATIENCE_SECONDS = 5.0


@dataclass(frozen=True)
class History:
    """What undo and redo would change, each in words, oldest first.

    Attributes:
        done: the last one is undone next.
        undone: the first one is redone next.
    """

    done: tuple[str, ...] = ()
    undone: tuple[str, ...] = ()


@dataclass(frozen=True)
class Watched:
    """One viewed agent.

    Attributes:
        vocabulary: what it can be commanded.
        training: what is being trained, if anything.
        history: what undo and redo would change in the training.
        behaviors: what is in its library and was needed, by name.
        readings: automaton, feature and its last values, oldest first.
        probed: the present values of all features, while a page asks for them.
        transitions: the last state changes, newest last.
        change: what the last change of examples did, and the number of examples before it.
        cost: what the training has cost so far.
        questions: of the agent to its demonstrator that are open.
    """

    vocabulary: Vocabulary = field(default_factory=Vocabulary)
    training: Learned | None = None
    history: History = field(default_factory=History)
    behaviors: Mapping[str, Learned] = field(default_factory=lambda: NOTHING)
    readings: Mapping[tuple[str, str], tuple[float, ...]] = field(default_factory=lambda: NOTHING)
    probed: Mapping[str, float] = field(default_factory=lambda: NOTHING)
    transitions: tuple[TransitionEvent, ...] = ()
    change: Effect | None = None
    cost: TrainingCost | None = None
    questions: tuple[Question, ...] = ()


class Watch:
    """Asks one agent, without ever waiting for an answer.

    Args:
        link: the node to use.
        agent: its name.
        status: returns its last status.
        changed: called when something new is known.
        failed: called with what went wrong with an answer.

    Attributes:
        known: what is known now.
    """

    def __init__(
        self,
        link: RosLink,
        agent: str,
        status: Callable[[], AgentStatus | None],
        changed: Callable[[], None],
        failed: Callable[[str, Exception], None],
        prefix: str = "",
    ) -> None:
        self.known = Watched()
        self._prefix = prefix
        self._link = link
        self._agent = agent
        self._status = status
        self._changed = changed
        self._failed = failed
        self._clients: dict[str, Any] = {}
        self._pending: dict[str, tuple[float, Any, Any]] = {}
        self._next_read = self._next_refresh = self._next_cost = 0.0
        self._library_key: tuple[Any, ...] = ()
        self._open = False
        self._training_key: tuple[Any, ...] = ()
        self._wanted: set[str] = set()
        self._probing = False
        self._history_of: Learned | None = None
        self._cost_of: Learned | None = None
        self._questions_of: tuple[Learned | None, int] = (None, 0)
        self._questions_at = math.inf
        self._transitions = link.subscribe(
            TransitionEvent,
            names.of_agent(agent, names.TRANSITIONS, prefix),
            self._take_event,
            qos.EVENTS,
            temporary=True,
        )

    def close(self) -> None:
        """Stop watching."""
        node = self._link.node
        node.destroy_subscription(self._transitions)
        for client in self._clients.values():
            node.destroy_client(client)

    def want(self, name: str) -> None:
        """Ask for a behavior of the library, to be known from now on."""
        self._wanted.add(name)

    def probe(self, *, on: bool) -> None:
        """Ask for the values of all features with all targets from now on, or no longer."""
        self._probing = on
        self._next_read = 0.0

    def look(self) -> None:
        """Request what may have changed."""
        status = self._status()
        if status is None:
            return
        now = time.monotonic()
        self._forget_unanswered(now)
        library_key = (status.library_digest, status.distribution)
        training = status.mode in (AgentStatus.TRAINING, AgentStatus.TESTING)
        was_open, self._open = self._open, training or status.examples > 0
        # What is saved again may have learned the same, under another version and description.
        ended = was_open and not self._open
        if library_key != self._library_key or ended or not self.known.vocabulary.domain:
            self._library_key = library_key
            self._know(behaviors=NOTHING)
            self._ask("vocabulary", GetVocabulary, "get_vocabulary", {}, self._take_vocabulary)
        key = (
            training,
            status.behavior if training else "",
            status.examples,
            status.last_command_sequence,
        )
        if key != self._training_key or (training and now >= self._next_refresh):
            self._training_key = key
            self._next_refresh = now + REFRESH_SECONDS
            if status.examples or training:
                self._ask("training", GetBehavior, "get_behavior", {}, self._take_training)
            elif self.known.training is not None:
                self._know(training=None, history=History(), cost=None, questions=())
                self._changed()
        trained = self.known.training
        if (
            trained is not None
            and trained is not self._history_of
            and self._ask("history", ListExamples, "list_examples", {}, self._take_history)
        ):
            self._history_of = trained
        if (
            trained is not None
            and (trained is not self._cost_of or now >= self._next_cost)
            and self._ask("cost", GetReport, names.GET_REPORT, {}, self._take_cost)
        ):
            self._cost_of, self._next_cost = trained, now + COST_SECONDS
        self._look_for_questions(status, now)
        for name in self._needed(status) - self.known.behaviors.keys():
            self._ask(name, GetBehavior, "get_behavior", {"name": name}, self._take_behavior)
        if now >= self._next_read:
            self._next_read = now + READ_SECONDS
            words = self.known.vocabulary
            also = (
                [str(u) for _, u in uses(words.features, words.targets)] if self._probing else []
            )
            fields = {"also": also[:PROBED_MAX]}
            self._ask("features", ReadFeatures, "read_features", fields, self._take_features)

    def _look_for_questions(self, status: AgentStatus, now: float) -> None:
        trained, (before, count) = self.known.training, self._questions_of
        if trained is not before or status.questions != count:
            self._questions_at = now + CALM_SECONDS
            self._questions_of = (trained, status.questions)
        if (
            trained is not None
            and now >= self._questions_at
            and self._ask(
                "questions", ListQuestions, names.LIST_QUESTIONS, {}, self._take_questions
            )
        ):
            self._questions_at = math.inf

    def refresh(self) -> None:
        """Ask for the training again, since examples were edited, and what is asked about it."""
        self._questions_of = (None, 0)
        self._next_refresh = 0.0
        self._training_key = ()
        self._pending.pop("training", None)

    def _needed(self, status: AgentStatus) -> set[str]:
        """Return what it has learned, and what is active or what that is made of."""
        known, seen = self.known, set(self._wanted)
        waiting = [Use.parse(s).name for s in [status.behavior, *status.active_path] if s]
        if known.training is not None:
            waiting += [Use.parse(s).name for s in known.training.states]
        while waiting:
            name = waiting.pop()
            if name in seen or name in FLAGS or name == START:
                continue
            if known.training is not None and name == known.training.name:
                continue
            seen.add(name)
            behavior = known.behaviors.get(name)
            if behavior is not None:
                waiting += [Use.parse(s).name for s in behavior.states]
        shelf = sorted(known.vocabulary.trained)[:SHELF_MAX]
        trained = known.training.name if known.training is not None else ""
        return seen | {name for name in shelf if name != trained}

    # -- asking -----------------------------------------------------------------------------

    def _ask(
        self, key: str, kind: Any, service: str, fields: dict[str, Any], take: Callable[..., None]
    ) -> bool:
        """Call a service, unless an answer is awaited; return whether it was called."""
        if key in self._pending:
            return False
        client = self._clients.get(service)
        if client is None:
            name = names.of_agent(self._agent, service, self._prefix)
            client = self._clients[service] = self._link.node.create_client(kind, name)
        if not client.service_is_ready():
            return False
        future = client.call_async(kind.Request(**fields))
        self._pending[key] = (time.monotonic(), client, future)

        def answered(done: Any) -> None:
            if self._pending.get(key, (0, 0, None))[2] is not done:
                return
            del self._pending[key]
            try:
                take(done.result(), **({"asked": key} if take == self._take_behavior else {}))
            except Exception as error:  # it is not the page that has to know how to read this
                self._failed(
                    f"The answer of {self._agent} to {service} cannot be read: "
                    f"{what_went_wrong(error)}",
                    error,
                )

        future.add_done_callback(answered)
        return True

    def _forget_unanswered(self, now: float) -> None:
        old = [k for k, (when, _, _) in self._pending.items() if now > when + PATIENCE_SECONDS]
        if "history" in old:
            self._history_of = None
        if "questions" in old:
            self._questions_of = (None, 0)
        for key in old:
            _, client, future = self._pending.pop(key)
            client.remove_pending_request(future)

    # -- answers ----------------------------------------------------------------------------

    def _know(self, **changes: Any) -> None:
        self.known = replace(self.known, **changes)

    def _take_event(self, event: TransitionEvent) -> None:
        self._know(transitions=(*self.known.transitions, event)[-EVENTS:])

    def _take_vocabulary(self, answer: Any) -> None:
        self._know(vocabulary=Vocabulary.of(answer))
        self._changed()

    def _take_training(self, answer: Any) -> None:
        before = self.known.training
        after = learned_of(answer) if answer.success else None
        if after == before:
            return
        change = None
        if before is not None and after is not None and before.name == after.name:
            change = effect(before, after)
        self._know(training=after, change=change)
        self._changed()

    def _take_history(self, answer: Any) -> None:
        if answer.success:
            self._know(history=History(tuple(answer.done), tuple(answer.undone)))
            self._changed()

    def _take_cost(self, answer: Any) -> None:
        costs = costs_of(answer) if answer.success else []
        self._know(cost=costs[-1] if costs and not costs[-1].finished else None)
        self._changed()

    def _take_questions(self, answer: Any) -> None:
        self._know(questions=tuple(answer.questions) if answer.success else ())
        self._changed()

    def _take_behavior(self, answer: Any, asked: str) -> None:
        if answer.success:
            behaviors = {**self.known.behaviors, asked: learned_of(answer)}
            self._know(behaviors=MappingProxyType(behaviors))
            self._changed()

    def _take_features(self, answer: Any) -> None:
        if not answer.success:
            return
        before = self.known.readings
        readings, probed = {}, {}
        for read in answer.readings:
            if read.automaton:
                past = before.get((read.automaton, read.feature), ())
                readings[read.automaton, read.feature] = (*past, read.value)[-HISTORY:]
            else:
                probed[read.feature] = read.value
        self._know(readings=MappingProxyType(readings), probed=MappingProxyType(probed))
