"""Endpoints that are created when the first node at their other end appears.

An agent has a dozen services, each with two endpoints, and topics that few ever use. DDS announces
each endpoint to every process of the swarm: a thousand agents would take minutes to start and
gigabytes to run. A host therefore looks for clients, publishers and subscribers, and creates what
they need when it finds one. The client's requests wait until then, as those of any client that
starts before its service; a reliable publisher waits for its match.
"""

from __future__ import annotations

from collections.abc import Callable

from hitab_agent.scheduler import Scheduler
from hitab_ros import GuardedNode
from hitab_ros.timing import LOOK_EACH_S, POLL_S


class EndpointsOnDemand:
    """Creates services and topics of a process's nodes for the first that asks for them."""

    def __init__(self, host: GuardedNode, scheduler: Scheduler, agents: int) -> None:
        """Begin to look for the other ends.

        Args:
            host: the node whose view of the ROS graph is used.
            scheduler: the process's scheduler.
            agents: number of the process's agents.
        """
        self._host = host
        self._services: dict[str, Callable[[], object]] = {}
        self._topics: dict[str, Callable[[], object]] = {}
        scheduler.every(max(POLL_S, agents * LOOK_EACH_S), self.look)

    def add_services(self, node: GuardedNode, offer: Callable[[], None]) -> None:
        """Call ``offer`` once, when a client of a service below the node's namespace appears."""
        guarded = node.guard.wrap("offering services", offer)
        namespaces = (node.get_namespace(), node.get_fully_qualified_name())

        def offer_once() -> None:
            for namespace in namespaces:
                self._services.pop(namespace, None)
            guarded()

        self._services |= dict.fromkeys(namespaces, offer_once)

    def add_topic(self, node: GuardedNode, name: str, offer: Callable[[], object]) -> None:
        """Call ``offer`` once, when the topic with a name relative to the node appears."""
        self._topics[node.resolve_topic_name(name)] = node.guard.wrap(f"offering {name}", offer)

    def look(self) -> None:
        """Look for the other ends."""
        services = self._host.get_service_names_and_types() if self._services else ()
        for service, _ in services:
            offer = self._services.get(service.rpartition("/")[0])
            if offer is not None:
                offer()
        topics = self._host.get_topic_names_and_types() if self._topics else ()
        for topic, _ in topics:
            offer = self._topics.pop(topic, None)
            if offer is not None:
                offer()
