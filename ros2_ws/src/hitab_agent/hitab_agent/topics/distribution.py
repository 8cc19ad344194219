"""Distribution of an agent's behavior, with all its parts, to other agents.

One message on a topic of the swarm reaches any number of receivers; each accepts all files or
none and acknowledges on another topic. The agents of a process verify and read it once, see
`hitab_agent.topics.bundle_install`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import JobQueue
from hitab_agent.topics.bundle_install import BundleInstall
from hitab_core import HitabError, Term
from hitab_core.library import Bundle
from hitab_core.training.operation import Shipment
from hitab_ros import GuardedNode, names, qos


class Distributions:
    """Sends and receives behaviors for all agents of a process."""

    def __init__(self, node: GuardedNode, nodes: Sequence[AgentBase]) -> None:
        """Start receiving.

        Args:
            node: the node to publish and subscribe on.
            nodes: the nodes of the receiving agents; read at each distribution.
        """
        distribution = names.in_swarm(node, names.DISTRIBUTION)
        self._outgoing = node.create_publisher(msg.Distribution, distribution, qos.EVENTS)
        self._acknowledgements = node.create_publisher(
            msg.DistributionAck, names.in_swarm(node, names.DISTRIBUTION_ACK), qos.ROLL_CALL
        )
        self._nodes = nodes
        self._jobs = JobQueue(node)
        node.create_subscription(msg.Distribution, distribution, self._on_distribution, qos.EVENTS)

    def _on_distribution(self, sent: msg.Distribution) -> None:
        named = set(sent.receivers)
        meant = [
            node
            for node in self._nodes
            if (node.agent_name in named if named else node.agent_name != sent.source)
        ]
        if meant:
            bundle = Bundle(tuple((f.name, f.text) for f in sent.files), sent.digest)
            start = Term(sent.behavior, tuple(sent.targets)) if sent.start else None
            self._jobs.do(BundleInstall(sent.sequence, bundle, start, meant, self._taken_in).job())

    def _taken_in(self, node: AgentBase, sequence: int, digest: str, error: str) -> None:
        """Publish the outcome of a distribution; a failure affects this agent only."""
        node.guard.run("distribution", self._acknowledge, node, sequence, digest, error)

    def _acknowledge(self, node: AgentBase, sequence: int, digest: str, error: str) -> None:
        # The status comes first: a client that has all acknowledgements compares the digests.
        node.answered(HitabError(error) if error else None)
        self._acknowledgements.publish(
            msg.DistributionAck(
                sequence=sequence,
                agent=node.agent_name,
                success=not error,
                digest=digest,
                message=error,
            )
        )

    def send(self, source: str, shipment: Shipment) -> int:
        """Send a behavior of an agent to others, and return the number of the distribution."""
        bundle, term = shipment.bundle, shipment.term
        # The time of day makes the number unique in the swarm, whichever agents distribute. A
        # node's clock may be simulated, and simulated time stands still in a paused world.
        sequence = time.time_ns()
        self._outgoing.publish(
            msg.Distribution(
                sequence=sequence,
                source=source,
                receivers=list(shipment.receivers),
                behavior=term.name,
                targets=list(term.arguments),
                digest=bundle.digest,
                files=[msg.BehaviorFile(name=n, text=t) for n, t in bundle.files],
                start=shipment.start,
            )
        )
        return sequence
