"""The operations of an agent as services of its node, and commands on topics.

An operation arrives with a request, or with a message on a topic of commands. It goes through one
function, `AgentBase.do`, which also publishes what became of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from hitab_msgs import msg, srv

from hitab_agent.endpoints import HeardTopic, OfferedService
from hitab_agent.node.agent_base import AgentBase
from hitab_core import HitabError, each_once, operations, some
from hitab_core.codec import from_dict
from hitab_core.training.operation import Operation
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import answering, refuse, what_went_wrong
from hitab_ros.messages.checks import BadMessage, check
from hitab_ros.messages.conversions import message_of


def command_topic(node: AgentBase) -> HeardTopic:
    """Return the topic of commands that need no answer: the status shows what became of them."""
    # `obey` checks a command, so that the status shows the sender what is wrong.
    take = partial(obey, node)
    return HeardTopic(node, msg.Command, names.COMMAND, qos.EVENTS, take, checked=False)


def obey(node: AgentBase, command: msg.Command) -> None:
    """Make an agent obey a command; its status shows what became of it."""
    try:
        check(command)
    except BadMessage as error:
        node.answered(error)
        return
    with suppress(HitabError):  # a refusal, which the status shows
        node.do(from_dict(operations.Command, command))


class CommandsToMany:
    """Receives commands to many agents at once, and passes on those to a host's own."""

    def __init__(self, host: GuardedNode, nodes: Sequence[AgentBase]) -> None:
        """Subscribe; ``nodes`` are the nodes of the host's agents, read at each message."""
        self._nodes = nodes
        topic = names.in_swarm(host, names.COMMANDS)
        host.create_subscription(msg.Commands, topic, self._pass_on, qos.EVENTS, checked=False)

    def _pass_on(self, batch: msg.Commands) -> None:
        if len(batch.agents) != len(batch.commands):
            raise HitabError(
                f"{len(batch.agents)} agents and {len(batch.commands)} commands came on the topic "
                f"{names.COMMANDS}; send one command for each agent"
            )
        commands = dict(zip(batch.agents, batch.commands, strict=True))
        for node in self._nodes:
            if (command := commands.get(node.agent_name)) is not None:
                node.guard.run("topic commands", obey, node, command)


def offer_loading(host: GuardedNode, nodes: Sequence[AgentBase]) -> None:
    """Offer a service of a host that loads the libraries of all of its agents.

    Asking each agent's own service would cost the swarm four endpoints an agent.

    Args:
        host: a node of the host, in its own namespace.
        nodes: the nodes of its agents, read at each request.
    """

    def load(request: Any, response: Any) -> str:
        done: list[tuple[str, str]] = []
        refused: list[tuple[str, str]] = []
        for node in nodes:
            try:
                outcome = node.do(from_dict(operations.LoadLibrary, request))
                done.append((node.agent_name, outcome.message))
            except Exception as error:  # of this agent only
                refused.append((node.agent_name, what_went_wrong(error)))
        if refused:
            raise HitabError(some(each_once(refused), between="; "))
        return some(each_once(done), between="; ")

    host.create_service(srv.LoadLibrary, operations.LoadLibrary.name, answering(load))


class AgentServices:
    """An agent's operations; a refusal is a reply with ``success`` false and the reason.

    Attributes:
        endpoints: the services.
    """

    def __init__(self, node: AgentBase) -> None:
        """Prepare the services of an agent's node."""
        self._node = node
        self.endpoints = [
            OfferedService(node, getattr(srv, kind.__name__), name, partial(self._serve, kind))
            for name, kind in operations.OPERATIONS.items()
        ]

    def _serve(self, kind: type[Operation], request: Any, response: Any) -> Any:
        """Carry out the operation of a request; the reply has the status after it."""
        try:
            outcome = self._node.do(from_dict(kind, request))
            response = message_of(type(response), outcome, success=True)
        except HitabError as error:
            refuse(response, error)
        response.status = self._node.status.message
        return response
