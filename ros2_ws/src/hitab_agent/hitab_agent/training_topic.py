"""Publishes an agent's training on a latched topic while the topic has a subscriber."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from hitab_msgs import msg

from hitab_agent.automaton_message import question_message, training_message
from hitab_agent.scheduler import Job, JobQueue, Scheduler
from hitab_core import Agent, TrainingSession
from hitab_core.assistant import unsaved_cost
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.conversions import cost_message, remark_messages

TRAINING_PERIOD_S = 0.1
"""Least time between two messages, s."""

CALM_S = 1.0
"""Time from a change to the search for questions, which takes up to a second of slices."""


class TrainingTopic:
    """Publishes each revision of the training under way, as a whole.

    A revision is published at once, and again when its questions have been looked for. Nothing is
    built without a subscriber.

    Attributes:
        revision: counts up with each change, of the mode too, also over restarts; 0 if nothing is
            being trained.
        searched: called whenever questions have been looked for.
    """

    def __init__(self, node: GuardedNode, agent: Agent, scheduler: Scheduler) -> None:
        """Know of no training yet.

        Args:
            node: of the agent.
            agent: the agent.
            scheduler: of its process.
        """
        self.revision = 0
        self.searched: Callable[[], None] = lambda: None
        self._node = node
        self._agent = agent
        self._scheduler = scheduler
        self._jobs: JobQueue | None = None
        self._publisher: Any = None
        self._last = time.time_ns() // 1000
        self._seen: tuple[Any, ...] = (None,)
        self._mode = agent.mode
        self._published: tuple[int, bool] = (0, True)
        self._cost = msg.TrainingCost()
        self._searched = 0
        self._searching = False
        self._changed_at = self._next = 0.0

    def offer(self) -> None:
        """Create the topic, unless it is there."""
        if self._publisher is None:
            self._publisher = self._node.create_publisher(
                msg.Training, names.TRAINING, qos.LATCHED
            )
            self._jobs = JobQueue(self._node)
            self._scheduler.every(TRAINING_PERIOD_S, self.look, self._node.guard)

    def notice(self) -> int:
        """Notice what has changed, and who decides; return the revision."""
        session, mode = self._agent.session, self._agent.mode
        seen = _marks(session)
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
        """Publish what has changed, if it is time and anybody subscribes."""
        session, now = self._agent.session, time.monotonic()
        self.notice()
        if self._publisher is None or now < self._next:
            return
        state = self.revision, self._searched == self.revision
        if state == self._published:
            self._search(session, now)
        elif session is None:
            self._cost = msg.TrainingCost()
            self._publish(msg.Training(agent=self._agent.name, revision=self._last), state)
        elif self._publisher.get_subscription_count():
            self._publish(self._message(session), state)
            self._next = time.monotonic() + TRAINING_PERIOD_S

    def _publish(self, message: msg.Training, state: tuple[int, bool]) -> None:
        self._published = state
        self._publisher.publish(message)

    def _message(self, session: TrainingSession) -> msg.Training:
        asked, history = session.questions, session.log.history
        searched = self._searched == self.revision
        if searched and (cost := unsaved_cost(self._agent.journal)) is not None:
            self._cost = cost_message(cost)
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
        """Begin to look for questions once there are no changes for a while."""
        if (
            session is not None
            and self._jobs is not None
            and self._searched != self.revision
            and not self._searching
            and now >= self._changed_at + CALM_S
            and self._publisher.get_subscription_count()
        ):
            self._searching = True
            self._jobs.do(self._searches(session, session.examples))

    def _searches(self, session: TrainingSession, examples: Any) -> Job:
        try:
            for _ in session.search():
                yield None
        except Exception as error:  # such as of a classifier; testing says so, too
            self._node.guard.log(what_went_wrong(error))
        self._searching = False
        if session is self._agent.session and examples is session.examples:
            self._searched = self.notice()
            self.searched()


def _marks(session: TrainingSession | None) -> tuple[Any, ...]:
    """Return marks that differ after a change of examples, or of the rest."""
    if session is None:
        return (None,)
    known = [question.number for question in session.questions.known()]
    more = len(session.questions.answered), session.questions.news, session.remarks()
    return session.examples, session, session.curriculum, known, more
