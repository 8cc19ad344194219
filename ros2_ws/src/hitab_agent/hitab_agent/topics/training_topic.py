"""Publishes an agent's training on a latched topic while the topic has a subscriber."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from hitab_msgs import msg

from hitab_agent.endpoints import PublishedTopic
from hitab_agent.scheduler import Job, JobQueue, Scheduler
from hitab_agent.topics.automaton_message import question_message, training_message
from hitab_core import Agent, TrainingSession
from hitab_core.assistant import unsaved_cost
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.messages.conversions import message_of, remark_messages
from hitab_ros.timing import SETTLE_S, UPDATE_S


class TrainingTopic:
    """Publishes each revision of the training under way, as a whole.

    A revision is published at once, and again when the search for its questions has ended. No
    message is built without a subscriber.

    Attributes:
        topic: the topic.
        revision: number that increases with each change of the training or the mode, also across
            restarts; 0 if nothing is being trained.
        searched: called after each search for questions.
    """

    def __init__(self, node: GuardedNode, agent: Agent, scheduler: Scheduler) -> None:
        """Prepare to publish.

        Args:
            node: the agent's node.
            agent: the agent.
            scheduler: the scheduler of the agent's process.
        """
        self.revision = 0
        self.searched: Callable[[], None] = lambda: None
        self._node = node
        self._agent = agent
        self._scheduler = scheduler
        self._jobs: JobQueue | None = None
        self.topic = PublishedTopic(
            node, msg.Training, names.TRAINING, qos.LATCHED, self._opened, self._closed
        )
        self._last = time.time_ns() // 1000
        self._seen: tuple[Any, ...] = (None,)
        self._mode = agent.mode
        self._published: tuple[int, bool] = (0, True)
        self._cost = msg.TrainingCost()
        self._searched = 0
        self._searching = False
        self._changed_at = self._next = 0.0

    def _opened(self) -> None:
        self._published = (0, True)
        if self._jobs is None:
            self._jobs = JobQueue(self._node)
        self._stop = self._scheduler.every(UPDATE_S, self.look, self._node.guard)

    def _closed(self) -> None:
        self._stop()

    def notice(self) -> int:
        """Compare the training and the mode with those published last; return the revision."""
        session, mode = self._agent.session, self._agent.mode
        seen = _fingerprint(session)
        changed = seen[0] is not self._seen[0] or seen[1:] != self._seen[1:]
        if changed or mode is not self._mode:
            searched = self._searched == self.revision and not changed
            self._seen, self._mode = seen, mode
            self._last += 1
            self.revision = self._last if session is not None else 0
            if searched:
                self._searched = self.revision
            if changed:
                self._changed_at = time.monotonic()
        return self.revision

    def look(self) -> None:
        """Publish a new revision, if it is due and the topic has a subscriber."""
        session, now = self._agent.session, time.monotonic()
        self.notice()
        if self.topic.end is None or now < self._next:
            return
        state = self.revision, self._searched == self.revision
        if state == self._published:
            self._search(session, now)
        elif session is None:
            self._cost = msg.TrainingCost()
            self._publish(msg.Training(agent=self._agent.name, revision=self._last), state)
        elif self.topic.is_listened_to:
            self._publish(self._message(session), state)
            self._next = time.monotonic() + UPDATE_S

    def _publish(self, message: msg.Training, state: tuple[int, bool]) -> None:
        self._published = state
        self.topic.publish(message)

    def _message(self, session: TrainingSession) -> msg.Training:
        asked, history = session.questions, session.log.history
        searched = self._searched == self.revision
        if searched and (cost := unsaved_cost(self._agent.journal)) is not None:
            self._cost = message_of(msg.TrainingCost, cost)
        return msg.Training(
            agent=self._agent.name,
            revision=self.revision,
            automaton=training_message(session, self._agent.domain),
            done=history.done,
            undone=history.undone,
            searched=searched,
            questions=[question_message(q, session) for q in asked.known()],
            answered=asked.answered,
            remarks=remark_messages(self._agent.remarks()),
            cost=self._cost,
        )

    def _search(self, session: TrainingSession | None, now: float) -> None:
        """Begin to search for questions after some time without changes."""
        if (
            session is not None
            and self._jobs is not None
            and self._searched != self.revision
            and not self._searching
            and now >= self._changed_at + SETTLE_S
            and self.topic.is_listened_to
        ):
            self._searching = True
            self._jobs.do(self._searches(session, session.examples))

    def _searches(self, session: TrainingSession, examples: Any) -> Job:
        try:
            for _ in session.search():
                yield None
        except Exception as error:  # such as of a classifier; a test reports it as well
            self._node.guard.log(what_went_wrong(error))
        self._searching = False
        if session is self._agent.session and examples is session.examples:
            self._searched = self.notice()
            self.searched()


def _fingerprint(session: TrainingSession | None) -> tuple[Any, ...]:
    """Return a fingerprint: the examples, then everything else whose change is published."""
    if session is None:
        return (None,)
    known = [question.number for question in session.questions.known()]
    more = len(session.questions.answered), session.questions.news, session.remarks()
    return session.examples, session, session.curriculum, known, more
