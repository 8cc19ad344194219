"""Distribution of an agent's behavior, with all its parts, to other agents.

One message on a topic of the swarm reaches any number of receivers; each accepts all files or
none and acknowledges on another topic. The agents of a process verify and read it once, see
`hitab_agent.intake`.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from hitab_msgs import msg, srv

from hitab_agent.intake import Intake
from hitab_agent.slices import Slices
from hitab_core import Agent, Use, VocabularyError, quantity
from hitab_core.library import Bundle, make_bundle
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import Answered, answering
from hitab_ros.conversions import use_of


class DistributionReceiver:
    """The topics of distribution; the agents of a process share one."""

    def __init__(self, node: GuardedNode) -> None:
        distribution = names.in_swarm(node, names.DISTRIBUTION)
        acknowledgement = names.in_swarm(node, names.DISTRIBUTION_ACK)
        self.outgoing = node.create_publisher(msg.Distribution, distribution, qos.EVENTS)
        self.acknowledge = node.create_publisher(
            msg.DistributionAck, acknowledgement, qos.ROLL_CALL
        )
        self._receivers: list[Distributor] = []
        self._slices = Slices(node)
        self._node = node
        self._topic = distribution

    def add(self, receiver: Distributor) -> None:
        """Have an agent receive distributions from now on."""
        if not self._receivers:
            self._node.create_subscription(
                msg.Distribution, self._topic, self._on_distribution, qos.EVENTS
            )
        self._receivers.append(receiver)

    def _on_distribution(self, sent: msg.Distribution) -> None:
        named = set(sent.receivers)
        meant = [
            receiver
            for receiver in self._receivers
            if (receiver.agent.name in named if named else receiver.agent.name != sent.source)
        ]
        if meant:
            bundle = Bundle(tuple((f.name, f.text) for f in sent.files), sent.digest)
            start = Use(sent.behavior, tuple(sent.arguments)) if sent.start else None
            self._slices.do(Intake(sent.sequence, bundle, start, meant).job())


class Distributor:
    """Sends and receives behaviors for one agent."""

    def __init__(
        self,
        node: GuardedNode,
        agent: Agent,
        topics: DistributionReceiver,
        *,
        answered: Answered,
        taken_in: Callable[[int, str, str], None],
    ) -> None:
        """Start receiving.

        Args:
            node: of the agent.
            agent: the agent.
            topics: the topics.
            answered: called before the reply to a request to distribute.
            taken_in: called with the outcome of a distribution, see `has_taken_in`, before it is
                acknowledged.
        """
        self._node = node
        self.agent = agent
        self._answered = answered
        self._taken_in = taken_in
        self._outgoing = topics.outgoing
        self._acknowledge = topics.acknowledge
        topics.add(self)

    def offer(self) -> None:
        """Offer the service that distributes."""
        self._node.create_service(
            srv.Distribute, names.DISTRIBUTE, answering(self._distribute, self._answered)
        )

    def _distribute(
        self, request: srv.Distribute.Request, response: srv.Distribute.Response
    ) -> str:
        agent = self.agent
        use = use_of(request.behavior, request.arguments)
        agent.check_saved(use.name)
        if request.start:
            agent.repertoire.check_state(use)
        agent.repertoire.get(use.name)  # unless it is unknown or lost
        if use.name not in agent.edition.files:
            raise VocabularyError(
                f'"{use.name}" does not need to be sent: it comes with domain '
                f'"{agent.domain.name}", which its agents have'
            )
        bundle = make_bundle(agent.edition.texts, agent.repertoire, use.name)
        # The time of day makes it unique in the swarm, whichever agents distribute; simulated
        # time, which a node may use, stands still while a world is paused.
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
        return f"sent {quantity(len(bundle.files), 'behavior')}"

    def has_taken_in(self, sequence: int, digest: str, error: str) -> None:
        """Publish the outcome of a distribution; see `hitab_agent.intake.Receiver`.

        A failure here affects this agent only, not the others.
        """
        self._node.guard.run("distribution", self._publish, sequence, digest, error)

    def _publish(self, sequence: int, digest: str, error: str) -> None:
        # The status first: whoever has all acknowledgements may compare the agents' digests.
        self._taken_in(sequence, digest, error)
        self._acknowledge.publish(
            msg.DistributionAck(
                sequence=sequence,
                agent=self.agent.name,
                success=not error,
                digest=digest,
                message=error,
            )
        )
