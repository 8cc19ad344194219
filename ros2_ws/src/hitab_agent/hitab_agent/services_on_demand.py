"""Services that are created when a client asks for them.

An agent has a dozen services, each with two endpoints that are announced to every process of the
swarm: a thousand agents would take minutes to start and gigabytes to run. Hardly any of these
services is ever called. A host therefore looks for clients; their requests wait until the
service exists, as with any client that starts before its service.
"""

from __future__ import annotations

from collections.abc import Callable

from hitab_ros import GuardedNode

LOOK_PERIOD_S = 0.25
LOOK_AT_PER_S = 500.0  # agents: looking takes time in proportion to their number


class ServicesOnDemand:
    """Has the nodes of a process offer their services when the first client appears."""

    def __init__(self, host: GuardedNode) -> None:
        self._host = host
        self._offers: dict[str, Callable[[], None]] = {}

    def add(self, node: GuardedNode, offer: Callable[[], None]) -> None:
        """Call ``offer`` once a client asks for a service in a node's namespace."""
        self._offers[node.get_namespace()] = node.guard.wrap("offering services", offer)

    def look(self) -> None:
        """Look for clients; call this a few times a second."""
        for service, _ in self._host.get_service_names_and_types():
            offer = self._offers.pop(service.rpartition("/")[0], None)
            if offer is not None:
                offer()
