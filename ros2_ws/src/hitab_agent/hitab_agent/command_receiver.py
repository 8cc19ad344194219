"""Carrying out the commands of demonstrators."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from hitab_msgs import msg
from rclpy.timer import Timer

from hitab_agent.status_publisher import StatusPublisher
from hitab_core import Agent, Request
from hitab_ros import GuardedNode, Patience, RecentRequests, names, qos, steady_timer
from hitab_ros.answering import what_went_wrong
from hitab_ros.checks import check
from hitab_ros.conversions import use_of
from hitab_ros.plain_text import plain

DEMONSTRATOR_MAX = 200  # characters of a demonstrator's name; a longer one is shortened
EARLY_S = 8.0
"""How long a command may be held back: less than its demonstrator waits for an acknowledgement."""

YOUNG_S = 50.0
"""For how long after its start an agent holds commands back until its first percept."""

LOOK_S = 0.05  # how often it looks for that


class CommandReceiver:
    """Has an agent carry out demonstrators' commands; its status acknowledges each one.

    An agent that was restarted in a training perceives only after a moment. What it is commanded
    before is held back until then.

    Attributes:
        obeying: called with each command before it is obeyed or refused.
    """

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        status: StatusPublisher,
        settle: Callable[[], None],
    ) -> None:
        """Subscribe to commands.

        Args:
            node: of the agent.
            agent: the agent.
            status: its status.
            settle: called after each command.
        """
        self._node = node
        self._agent = agent
        self.obeying: Callable[[msg.Command], None] = lambda command: None
        self._early: list[msg.Command] = []
        self._timer: Timer | None = None
        self._young_until = time.monotonic() + YOUNG_S
        self._status = status
        self._settle = settle
        self._recent: RecentRequests[str] = RecentRequests()  # why refused, or ""
        for request in agent.session.requests if agent.session is not None else ():
            # Obeyed before a crash: their demonstrators may not know it and send them again.
            self._recent.keep(*request, "")
            status.message.last_command_sequence = request.number
        # Checked below, so that the status shows the sender what is wrong.
        node.create_subscription(
            msg.Command, names.COMMAND, self._on_command, qos.EVENTS, checked=False
        )

    def _on_command(self, command: msg.Command) -> None:
        if self._timer is not None:  # in the order in which they came
            if command not in self._early:  # what is sent again is the same
                self._early.append(command)
        elif self._agent.awaits_percept and time.monotonic() < self._young_until:
            self._early.append(command)
            self._timer = steady_timer(self._node, LOOK_S, partial(self._look, Patience(EARLY_S)))
        else:
            self._obey(command)

    def _look(self, patience: Patience) -> None:
        """Obey what was held back, once that is possible or will not be."""
        if self._timer is None or (self._agent.awaits_percept and patience.step(LOOK_S)):
            return
        self._node.destroy_timer(self._timer)
        self._timer = None
        early, self._early = self._early, []
        for command in early:
            self._obey(command)

    def _obey(self, command: msg.Command) -> None:
        self.obeying(command)
        status = self._status.message
        status.demonstrator = plain(command.demonstrator, DEMONSTRATOR_MAX, lines=False)
        # A command resent because its acknowledgement was late is acknowledged again.
        refusal = self._recent.came_of(status.demonstrator, command.sequence)
        try:
            if refusal is None:
                refusal = ""
                check(command)
                use = use_of(command.behavior, command.targets)
                request = Request(status.demonstrator, command.sequence)
                self._agent.command(
                    use,
                    ago=command.ago,
                    seen=command.seen,
                    request=request if request.number else None,
                )
        except Exception as error:
            refusal = what_went_wrong(error)
        finally:
            self._recent.keep(status.demonstrator, command.sequence, refusal or "")
            if refusal:
                status.last_refused_sequence = command.sequence
            else:
                status.last_command_sequence = command.sequence
            self._status.report_error(refusal or "")
            self._settle()
