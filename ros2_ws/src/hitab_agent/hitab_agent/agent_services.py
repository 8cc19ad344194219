"""The operations of an agent as services of its node.

An operation arrives with a request, or with a message on the command topic. It goes through one
function, `AgentBase.do`, which also publishes what became of it.
"""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.node.agent_base import AgentBase
from hitab_core import HitabError, operations
from hitab_core.codec import from_dict
from hitab_core.training.operation import Operation
from hitab_ros import names, qos
from hitab_ros.answering import refuse
from hitab_ros.messages.checks import BadMessage, check
from hitab_ros.messages.conversions import message_of


class CommandTopic:
    """Receives commands that need no answer; the agent's status shows what became of them."""

    def __init__(self, node: AgentBase) -> None:
        """Subscribe to commands."""
        self._node = node
        # Checked below, so that the status shows the sender what is wrong.
        node.create_subscription(
            msg.Command, names.COMMAND, self._on_command, qos.EVENTS, checked=False
        )

    def _on_command(self, command: msg.Command) -> None:
        try:
            check(command)
        except BadMessage as error:
            self._node.answered(error)
            return
        with suppress(HitabError):  # a refusal, which the status shows
            self._node.do(from_dict(operations.Command, command))


class AgentServices:
    """Offers an agent's operations; a refusal is a reply with ``success`` false and the reason."""

    def __init__(self, node: AgentBase) -> None:
        """Offer the services of an agent's node."""
        self._node = node
        for name, kind in operations.OPERATIONS.items():
            serve = partial(self._serve, kind)
            node.create_service(getattr(srv, kind.__name__), name, serve)

    def _serve(self, kind: type[Operation], request: Any, response: Any) -> Any:
        """Carry out the operation of a request; the reply has the status after it."""
        try:
            outcome = self._node.do(from_dict(kind, request))
            response = message_of(type(response), outcome, success=True)
        except HitabError as error:
            refuse(response, error)
        response.status = self._node.status.message
        return response
