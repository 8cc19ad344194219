"""Giving one agent's behavior, with all that it is made of, to other agents.

One message on a topic of the swarm reaches any number of receivers; each verifies the digest,
takes all files or none, and answers on another topic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hitab_msgs import msg, srv

from hitab_core.bundle import Bundle, make_bundle
from hitab_core.errors import VocabularyError
from hitab_core.use import Use
from hitab_ros import names, qos
from hitab_ros.answering import answering, what_went_wrong
from hitab_ros.conversions import use_of

if TYPE_CHECKING:
    from hitab_agent.agent_node import AgentNode


class Distributor:
    """Sends and receives behaviors for one agent."""

    def __init__(self, node: AgentNode) -> None:
        self._node = node
        self._agent = node.agent
        distribution = names.in_swarm(node, names.DISTRIBUTION)
        acknowledgement = names.in_swarm(node, names.DISTRIBUTION_ACK)
        self._outgoing = node.create_publisher(msg.Distribution, distribution, qos.EVENTS)
        self._acknowledge = node.create_publisher(msg.DistributionAck, acknowledgement, qos.EVENTS)
        node.create_subscription(msg.Distribution, distribution, self._receive, qos.EVENTS)
        node.create_service(
            srv.Distribute, names.DISTRIBUTE, answering(self._distribute, node.report_error)
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
        # The time makes it unique in the swarm, whoever else distributes.
        sequence = self._node.get_clock().now().nanoseconds
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
