"""Distribution of an agent's behavior, with all its parts, to other agents.

One message on a topic of the swarm reaches any number of receivers; each accepts all files or
none and acknowledges on another topic. The agents of a process verify and read it once, see
`hitab_agent.bundle_install`.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial

from hitab_msgs import msg, srv

from hitab_agent.agent_base import AgentBase
from hitab_agent.bundle_install import BundleInstall
from hitab_agent.scheduler import JobQueue
from hitab_core import Term, VocabularyError, quantity
from hitab_core.library import Bundle, make_bundle
from hitab_ros import GuardedNode, names, qos
from hitab_ros.answering import answering
from hitab_ros.conversions import term_of


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
            start = Term(sent.behavior, tuple(sent.arguments)) if sent.start else None
            self._jobs.do(BundleInstall(sent.sequence, bundle, start, meant, self._taken_in).job())

    def _taken_in(self, node: AgentBase, sequence: int, digest: str, error: str) -> None:
        """Publish the outcome of a distribution; a failure affects this agent only."""
        node.guard.run("distribution", self._acknowledge, node, sequence, digest, error)

    def _acknowledge(self, node: AgentBase, sequence: int, digest: str, error: str) -> None:
        # The status comes first: a client that has all acknowledgements compares the digests.
        node.taken_in(sequence, digest, error)
        self._acknowledgements.publish(
            msg.DistributionAck(
                sequence=sequence,
                agent=node.agent_name,
                success=not error,
                digest=digest,
                message=error,
            )
        )

    def offer(self, node: AgentBase) -> None:
        """Offer the service by which an agent distributes."""
        serve = answering(partial(self._distribute, node), node.answered)
        node.create_service(srv.Distribute, names.DISTRIBUTE, serve)

    def _distribute(
        self,
        node: AgentBase,
        request: srv.Distribute.Request,
        response: srv.Distribute.Response,
    ) -> str:
        agent = node.agent
        term = term_of(request.behavior, request.arguments)
        agent.check_saved(term.name)
        if request.start:
            agent.repertoire.check_state(term)
        agent.repertoire.get(term.name)  # unless it is unknown or lost
        if term.name not in agent.loaded.files:
            raise VocabularyError(
                f'"{term.name}" does not need to be sent: it comes with domain '
                f'"{agent.domain.name}", which its agents have'
            )
        bundle = make_bundle(agent.loaded.texts, agent.repertoire, term.name)
        # The time of day makes the number unique in the swarm, whichever agents distribute. A
        # node's clock may be simulated, and simulated time stands still in a paused world.
        response.sequence, response.digest = time.time_ns(), bundle.digest
        self._outgoing.publish(
            msg.Distribution(
                sequence=response.sequence,
                source=agent.name,
                receivers=list(request.receivers),
                behavior=term.name,
                arguments=list(term.arguments),
                digest=bundle.digest,
                files=[msg.BehaviorFile(name=n, text=t) for n, t in bundle.files],
                start=request.start,
            )
        )
        broken = [text for name, _ in bundle.files for text in agent.loaded.files[name].broken]
        return "; but ".join([f"sent {quantity(len(bundle.files), 'behavior')}", *broken])
