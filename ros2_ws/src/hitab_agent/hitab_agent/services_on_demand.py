"""Services that are created when their first client appears.

An agent has a dozen services, each with two endpoints that DDS announces to every process of the
swarm: a thousand agents would take minutes to start and gigabytes to run. Hardly any of these
services is ever called. A host therefore looks for clients and creates a service when it finds
one. The client's requests wait until then, as those of any client that starts before its service.
"""

from __future__ import annotations

from collections.abc import Callable

from hitab_agent.scheduler import Scheduler
from hitab_ros import GuardedNode
from hitab_ros.timing import LOOK_EACH_S, POLL_S


class ServicesOnDemand:
    """Makes the nodes of a process offer their services when the first client appears."""

    def __init__(self, host: GuardedNode, scheduler: Scheduler, agents: int) -> None:
        """Begin to look for clients.

        Args:
            host: the node whose view of the ROS graph is used.
            scheduler: the process's scheduler.
            agents: how many nodes there will be.
        """
        self._host = host
        self._offers: dict[str, Callable[[], None]] = {}
        scheduler.every(max(POLL_S, agents * LOOK_EACH_S), self.look)

    def add(self, node: GuardedNode, offer: Callable[[], None]) -> None:
        """Call ``offer`` once, when a client of a service below the node's namespace appears."""
        guarded = node.guard.wrap("offering services", offer)
        namespaces = (node.get_namespace(), node.get_fully_qualified_name())

        def offer_once() -> None:
            for namespace in namespaces:
                self._offers.pop(namespace, None)
            guarded()

        self._offers |= dict.fromkeys(namespaces, offer_once)

    def look(self) -> None:
        """Look for clients."""
        for service, _ in self._host.get_service_names_and_types():
            offer = self._offers.get(service.rpartition("/")[0])
            if offer is not None:
                offer()
