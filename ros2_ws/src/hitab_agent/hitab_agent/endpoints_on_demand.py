"""Endpoints that exist while there is a node at their other end; see `hitab_agent.endpoints`.

A client's requests wait until the service is there, as those of any client that starts before its
service; a reliable publisher such as that of ``ros2 topic pub`` waits for its match.
"""

from __future__ import annotations

from itertools import chain

from hitab_agent.endpoints import Endpoint
from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import Scheduler
from hitab_ros import GuardedNode
from hitab_ros.timing import POLL_S

UNUSED_LOOKS = 40
"""Looks after which an endpoint that nobody uses any more goes: ten seconds, since most people who
ask once ask again."""


class EndpointsOnDemand:
    """Opens and closes the endpoints of a process's agents."""

    def __init__(self, host: GuardedNode, scheduler: Scheduler) -> None:
        """Begin to look for the other ends.

        Args:
            host: the node whose view of the ROS graph is used.
            scheduler: the process's scheduler.
        """
        self._host = host
        self._nodes: dict[str, AgentBase] = {}  # by namespace
        self._open: dict[str, tuple[AgentBase, Endpoint]] = {}
        self._unused: dict[str, int] = {}  # looks since its last use, by name
        scheduler.every(POLL_S, self.look)

    def add(self, node: AgentBase) -> None:
        """Look for those who ask for endpoints of an agent from now on."""
        self._nodes[node.get_namespace()] = node

    def look(self) -> None:
        """Open what is asked for, and close what has not been used for a while."""
        for name, (node, endpoint) in [*self._open.items()]:
            unused = 0 if endpoint.is_asked_for(self._host) else self._unused.get(name, 0) + 1
            self._unused[name] = unused
            if unused > UNUSED_LOOKS:
                del self._open[name], self._unused[name]
                node.guard.run(f"closing {name}", endpoint.close)
        if not self._nodes:
            return
        host = self._host
        for name, _ in chain(host.get_topic_names_and_types(), host.get_service_names_and_types()):
            namespace, _, own = name.rpartition("/")
            node = self._nodes.get(namespace)
            if node is not None and name not in self._open:
                node.guard.run(f"offering {name}", self._offer, node, own)

    def _offer(self, node: AgentBase, name: str) -> None:
        endpoint: Endpoint | None = node.endpoints.find(name)
        if endpoint is not None and endpoint.end is None and endpoint.is_asked_for(self._host):
            endpoint.open()
            self._open[endpoint.name] = node, endpoint
