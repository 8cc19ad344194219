"""The receiver of demonstrators' commands."""

from __future__ import annotations

import time

from hitab_msgs import msg

from hitab_agent.agent_base import AgentBase
from hitab_core import Fix, Given, Request, TrainingError, some
from hitab_ros import RecentRequests, names, qos
from hitab_ros.checks import check
from hitab_ros.conversions import term_of
from hitab_ros.plain_text import plain

DEMONSTRATOR_MAX = 200  # characters of a demonstrator's name; a longer one is shortened
TOGETHER_S = 10.0
"""The status names demonstrators who command an agent within this time of each other, s."""

UNANSWERED_S = 50.0
"""How long after its start an agent leaves commands unanswered while it has no percept, s."""


class CommandReceiver:
    """Makes an agent carry out demonstrators' commands; its status acknowledges each command.

    An agent that was restarted in a training gets its first percept after a moment. Earlier
    commands stay unanswered, so that the demonstrator's client sends them again.
    """

    def __init__(self, node: AgentBase) -> None:
        """Subscribe to commands."""
        self._node = node
        self._unanswered_until = time.monotonic() + UNANSWERED_S
        self._heard: dict[str, float] = {}  # when each demonstrator last commanded
        self._recent: RecentRequests[tuple[Exception, ...]] = RecentRequests()  # why refused
        session = node.agent.session
        for request in session.requests if session is not None else ():
            # The agent obeyed these before a crash. Their demonstrators may not know that, and
            # send them again.
            self._recent.keep(*request, ())
            node.status.message.last_command_sequence = request.number
        # Checked below, so that the status shows the sender what is wrong.
        node.create_subscription(
            msg.Command, names.COMMAND, self._on_command, qos.EVENTS, checked=False
        )

    def _on_command(self, command: msg.Command) -> None:
        node, agent, status = self._node, self._node.agent, self._node.status.message
        if agent.awaits_percept and time.monotonic() < self._unanswered_until:
            return
        status.demonstrator = plain(command.demonstrator, DEMONSTRATOR_MAX, lines=False)
        # A command resent because its acknowledgement was late is acknowledged again.
        refusal = self._recent.came_of(status.demonstrator, command.sequence)
        try:
            if refusal is None:
                refusal = ()
                check(command)
                term = term_of(command.behavior, command.targets)
                stop = node.stop
                if stop is not None and stop.why and not agent.repertoire.stands_still(term):
                    # The example would record something that the robot did not do.
                    raise TrainingError(stop.why, Fix.ARM(robot=agent.name))
                request = Request(status.demonstrator, command.sequence)
                asked_by = request if request.number else None
                given = Given(0, command.ago, command.seen, command.pace, asked_by)
                taught = agent.command(term, given, unrecorded=command.unrecorded)
                status.left = taught[0].state if taught else ""
        except Exception as error:
            refusal = (error,)
        node.status.together = self._together(status.demonstrator or "a person")
        self._recent.keep(status.demonstrator, command.sequence, refusal)
        if refusal:
            status.last_refused_sequence = command.sequence
        else:
            status.last_command_sequence = command.sequence
        node.status.report_error(refusal[0] if refusal else None)
        node.settle()

    def _together(self, demonstrator: str) -> str:
        """Return the people who command the agent at the same time; empty if only one does."""
        now = time.monotonic()
        heard = {who: at for who, at in self._heard.items() if now - at <= TOGETHER_S}
        self._heard = heard | {demonstrator: now}
        people = some(sorted(self._heard), between=" and ")
        return f"is commanded by {people} at the same time" if len(self._heard) > 1 else ""
