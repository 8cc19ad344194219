"""Carrying out the commands of demonstrators."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs import msg

from hitab_agent.status_publisher import StatusPublisher
from hitab_core import Agent
from hitab_ros import GuardedNode, RecentRequests, names, qos
from hitab_ros.answering import what_went_wrong
from hitab_ros.checks import check
from hitab_ros.conversions import use_of
from hitab_ros.plain_text import plain

DEMONSTRATOR_MAX = 200  # characters of a demonstrator's name; the rest is cut off


class CommandReceiver:
    """Has an agent carry out demonstrators' commands; its status acknowledges each one."""

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
        self._agent = agent
        self._status = status
        self._settle = settle
        self._recent: RecentRequests[str] = RecentRequests()  # why refused, or ""
        # Checked below, so that the status shows the sender what is wrong.
        node.create_subscription(
            msg.Command, names.COMMAND, self._on_command, qos.EVENTS, checked=False
        )

    def _on_command(self, command: msg.Command) -> None:
        status = self._status.message
        status.demonstrator = plain(command.demonstrator, DEMONSTRATOR_MAX)
        # A command resent because its acknowledgement was late is acknowledged again.
        refusal = self._recent.came_of(status.demonstrator, command.sequence)
        try:
            if refusal is None:
                refusal = ""
                check(command)
                use = use_of(command.behavior, command.targets)
                self._agent.command(use, ago=command.ago, seen=command.seen)
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
