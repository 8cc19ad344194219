"""Giving one agent's behavior, with all that it is made of, to other agents.

One message on a topic of the swarm reaches any number of receivers; each verifies the digest,
takes all files or none, and answers on another topic.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from hitab_msgs import msg, srv

from hitab_core.bundle import Bundle, make_bundle
from hitab_core.errors import VocabularyError
from hitab_core.use import Use
from hitab_ros import names, qos
from hitab_ros.answering import answering, what_went_wrong
from hitab_ros.conversions import use_of
from hitab_ros.guard import Guard
from hitab_ros.guarded_node import GuardedNode

if TYPE_CHECKING:
    from hitab_agent.agent_node import AgentNode


class DistributionDesk:
    """The topics of distribution; the agents of a process share one."""

    def __init__(self, node: GuardedNode) -> None:
        distribution = names.in_swarm(node, names.DISTRIBUTION)
        acknowledgement = names.in_swarm(node, names.DISTRIBUTION_ACK)
        self.outgoing = node.create_publisher(msg.Distribution, distribution, qos.EVENTS)
        self.acknowledge = node.create_publisher(msg.DistributionAck, acknowledgement, qos.EVENTS)
        self._receivers: list[Callable[[msg.Distribution], None]] = []
        self._node = node
        self._topic = distribution

    def add(self, receive: Callable[[msg.Distribution], None], guard: Guard) -> None:
        """Have an agent receive what is distributed from now on, under its own guard."""
        if not self._receivers:
            self._node.create_subscription(
                msg.Distribution, self._topic, self._on_distribution, qos.EVENTS
            )
        self._receivers.append(guard.wrap("distribution", receive))

    def _on_distribution(self, sent: msg.Distribution) -> None:
        for receive in self._receivers:
            receive(sent)


class Distributor:
    """Sends and receives behaviors for one agent."""

    def __init__(self, node: AgentNode, desk: DistributionDesk) -> None:
        self._node = node
        self._agent = node.agent
        self._outgoing = desk.outgoing
        self._acknowledge = desk.acknowledge
        desk.add(self._receive, node.guard)

    def offer(self) -> None:
        """Offer the service that distributes."""
        self._node.create_service(
            srv.Distribute, names.DISTRIBUTE, answering(self._distribute, self._node.report_error)
        )

    def _distribute(
        self, request: srv.Distribute.Request, response: srv.Distribute.Response
    ) -> str:
        agent = self._agent
        use = use_of(request.behavior, request.arguments)
        if request.start:
            agent.repertoire.check_state(use)
        if use.name not in agent.library.names():
            raise VocabularyError(
                f'"{use.name}" is not in the library of {agent.name}; save it first'
            )
        bundle = make_bundle(agent.library.texts(), agent.repertoire, use.name)
        # The time of day makes it unique in the swarm, whoever else distributes; simulated time,
        # which a node may go by, stands still while a world is paused.
        sequence = time.time_ns()
        self._outgoing.publish(
            msg.Distribution(
                sequence=sequence,
                source=agent.name,
                receivers=list(request.receivers),
                behavior=use.name,
                arguments=list(use.arguments),
                digest=bundle.digest,
                files=[msg.BehaviorFile(name=n, text=t) for n, t in bundle.files],
                start=request.start,
            )
        )
        response.sequence = sequence
        response.digest = bundle.digest
        return f"sent {len(bundle.files)} behaviors"

    def _receive(self, sent: msg.Distribution) -> None:
        agent = self._agent
        meant = agent.name in sent.receivers if sent.receivers else agent.name != sent.source
        if not meant:
            return
        answer = msg.DistributionAck(sequence=sent.sequence, agent=agent.name)
        try:
            bundle = Bundle(tuple((f.name, f.text) for f in sent.files), sent.digest)
            answer.digest = agent.take_in(bundle)
            if sent.start:
                agent.perform(Use(sent.behavior, tuple(sent.arguments)))
            answer.success = True
            self._node.settle()
        except Exception as error:
            answer.message = what_went_wrong(error)
        # The status first: who has all acknowledgements may look at everybody's digest.
        self._node.report_distribution(sent.sequence, answer.message)
        self._acknowledge.publish(answer)
