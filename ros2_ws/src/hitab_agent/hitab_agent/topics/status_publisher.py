"""The publisher of an agent's status: its activity and its faults."""

from __future__ import annotations

import secrets
import time
from collections.abc import Callable
from typing import NamedTuple

from hitab_msgs import msg

from hitab_agent.endpoints import PublishedTopic
from hitab_agent.host_resources import HostResources
from hitab_agent.links.superior_link import SuperiorLink
from hitab_agent.node.settings import AgentParameters
from hitab_agent.topics.transition_log import TransitionLog
from hitab_core import NOTHING, Agent, Mode, some
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.messages.conversions import message_of, remedy_messages
from hitab_ros.messages.plain_text import plain
from hitab_ros.nodes.faults import shown

DEMONSTRATOR_MAX = 200  # characters of a demonstrator's name; a longer one is shortened
TOGETHER_S = 10.0
"""The status names demonstrators who command an agent within this time of each other, s."""


class Beginning(NamedTuple):
    """The outcome of an agent's start.

    Attributes:
        fault: why the start failed; empty if it succeeded.
        note: what a restarted agent resumed; empty after a first start.
    """

    fault: str = ""
    note: str = ""


class StatusPublisher:
    """Publishes an agent's status, at once or a little later.

    Attributes:
        message: the status; the handlers of requests record their outcome in it.
        topic: the agent's own topic of its status.
        path: the last published path of active states.
        decided_at: distance of recent decisions that were far from all examples; 0 if near.
        preview: what it would do next, as last seen; published while it is trained or tested.
        superior: the link to the agent's commander; None if it has none.
    """

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        settings: AgentParameters,
        shared: HostResources,
        transitions: TransitionLog,
        prepare: Callable[[], None],
    ) -> None:
        """Create the publisher; nothing is published yet.

        Args:
            node: the agent's node.
            agent: the agent.
            settings: the agent's parameters.
            shared: the resources of the agent's process.
            transitions: the log of the agent's state changes.
            prepare: called before each status is published.
        """
        self.message = msg.AgentStatus(agent=agent.name, domain=agent.domain.name)
        self.message.process = secrets.randbits(63)
        self.message.armed = True
        self.message.swarm = settings.swarm
        self.message.when_out_of_reach = settings.when_out_of_reach
        self.path: list[str] = []
        self.decided_at = 0.0
        self.preview = NOTHING
        self.superior: SuperiorLink | None = None
        self._together = ""
        self._commanded: dict[str, float] = {}  # when each demonstrator last commanded
        self._guard = node.guard
        self._agent = agent
        self._shared = shared
        self._transitions = transitions
        self._prepare = prepare
        self._error = ""
        self._began = Beginning()
        self._began_in: tuple[object, ...] = ()
        self._is_due = False
        self.topic = PublishedTopic(
            node, msg.AgentStatus, names.STATUS, qos.LATCHED, latched=self._publish_again
        )

    @property
    def refusal(self) -> str:
        """Why a waiting order cannot be obeyed; empty if no order waits."""
        return "" if self.superior is None else self.superior.subordinate.refusal

    @property
    def notice(self) -> str:
        """Why the last command or request was refused, or else why the start failed, if it did."""
        return self._error or self._beginning.fault

    @property
    def _beginning(self) -> Beginning:
        """The outcome of the start, until the agent does something else or records an example."""
        if self._began_in != self._state:
            self._began = Beginning()
        return self._began

    @property
    def _state(self) -> tuple[object, ...]:
        session = self._agent.session
        return self._agent.mode, self._agent.behavior, len(session.log) if session else 0

    @property
    def faults(self) -> list[str]:
        """The lasting faults, each shown until its cause is gone."""
        refusal = self.refusal
        waits = shown([refusal] if refusal else [])
        missing = shown(self._agent.faults)
        began = shown(filter(None, [self._beginning.fault]))
        return [*waits, *self._guard.faults.texts(), *self._shared.faults, *missing, *began]

    def report_error(self, error: Exception | None) -> None:
        """Publish the reason for a refusal or, without one, the lasting faults."""
        text = what_went_wrong(error) if error is not None else ""
        if text:
            self._guard.log(str(error))
        if text != self._error:
            self._shared.diagnostics.soon()
        self._error = text
        self.publish()

    def commanded(self, demonstrator: str) -> None:
        """Note who commands the agent, and whether others do at the same time."""
        self.message.training.demonstrator = plain(demonstrator, DEMONSTRATOR_MAX, lines=False)
        now = time.monotonic()
        recent = {who: at for who, at in self._commanded.items() if now - at <= TOGETHER_S}
        self._commanded = recent | {self.message.training.demonstrator or "a person": now}
        people = some(sorted(self._commanded), between=" and ")
        several = len(self._commanded) > 1
        self._together = f"is commanded by {people} at the same time" if several else ""

    def began(self, *, fault: str = "", note: str = "") -> None:
        """Publish the outcome of the start, until the agent does something else or has an example.

        Args:
            fault: why the start failed; empty if it succeeded. A fault is not a refusal.
            note: what a restarted agent resumed; empty after a first start.
        """
        self._began, self._began_in = Beginning(fault, note), self._state
        if fault:
            self._shared.diagnostics.soon()
        if fault or note:
            self._guard.log(fault or f"{self._agent.name} {note}")
        self.publish()

    def publish(self) -> None:
        """Publish the agent's present activity."""
        self._transitions.look()  # a new subscriber gets the next change
        self._prepare()
        agent, status = self._agent, self.message
        session = agent.session
        self._log_missing()
        self.path = agent.active_path
        status.sequence += 1
        status.mode = agent.mode.value
        status.behavior = agent.behavior
        status.active_path = self.path
        examples = session.examples if session else ()
        training, caution = status.training, status.caution
        training.automaton = agent.training
        training.examples = len(examples)
        training.default_examples = sum(example.is_default for example in examples)
        training.questions = len(session.questions.known()) if session else 0
        training.remarks = len(agent.remarks())
        caution.unsure = agent.monitor.unsure
        caution.when_unsure = agent.monitor.caution.when_unsure.value
        caution.distance = agent.monitor.caution.distance
        caution.decided_at = self.decided_at
        if agent.mode not in (Mode.TRAINING, Mode.TESTING):
            self.preview = NOTHING
        status.preview = message_of(msg.Preview, self.preview)
        status.breakpoints = list(map(str, agent.breakpoints.set))
        status.held = agent.held
        status.cycle = agent.cycle
        status.perceived = agent.context.feature_cache.perceived
        status.library_digest = agent.loaded.digest
        faults = self.faults
        status.faults = faults
        status.remedies = remedy_messages([*self._guard.faults.remedies, *agent.remedies])
        note = session.note if session and agent.mode is Mode.TRAINING else ""
        notes = [note or self._beginning.note, self._together if session else ""]
        status.note = "; ".join(shown(filter(None, notes)))
        status.last_error = self.notice or (faults[0] if faults else "")
        if self.superior is not None:
            subordinate = self.superior.subordinate
            status.order.commander = self.superior.commander
            status.order.behavior = subordinate.ordered or ""
            status.order.waits = subordinate.waits
        self.topic.publish(status)
        if self._shared.batches is not None:
            self._shared.batches.tell_status(status)

    def _publish_again(self) -> None:
        if self.message.sequence:
            self.topic.publish(self.message)

    def _log_missing(self) -> None:
        """Log the agent's lost behaviors, each once for all agents of the process."""
        for fault in self._agent.faults:
            if fault not in self._shared.logged:
                self._shared.logged.add(fault)
                self._guard.log(fault)

    @property
    def is_read(self) -> bool:
        """Whether somebody reads the status."""
        batches = self._shared.batches
        return self.topic.is_listened_to or (batches is not None and batches.are_read)

    def publish_soon(self) -> None:
        """Publish the status a little later, once for all changes in between."""
        if not self._is_due:
            self._is_due = True
            self._shared.statuses.call(self._due)

    def _due(self) -> None:
        self._is_due = False
        self.publish()
