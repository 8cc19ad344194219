"""Endpoints that exist while there is a node at their other end; see `hitab_agent.endpoints`.

A client's requests wait until the service is there, as those of any client that starts before its
service; a reliable publisher such as that of ``ros2 topic pub`` waits for its match.
"""

from __future__ import annotations

from hitab_agent.endpoints import Endpoint
from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import Scheduler
from hitab_ros import GuardedNode
from hitab_ros.timing import POLL_S

UNUSED_LOOKS = 40
"""Looks after which an endpoint that nobody uses any more goes: ten seconds, since most people who
ask once ask again."""


Key = tuple[bool, str]
"""Whether it is a service, and its full name: a topic and a service may have the same."""


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
        self._open: dict[Key, tuple[AgentBase, Endpoint]] = {}
        self._unused: dict[Key, int] = {}  # looks since the last use
        scheduler.every(POLL_S, self.look)

    def add(self, node: AgentBase) -> None:
        """Look for those who ask for endpoints of an agent from now on."""
        self._nodes[node.get_namespace()] = node

    def look(self) -> None:
        """Open what is asked for, and close what has not been used for a while."""
        for key, (node, endpoint) in [*self._open.items()]:
            unused = 0 if endpoint.is_asked_for(self._host) else self._unused.get(key, 0) + 1
            self._unused[key] = unused
            if unused > UNUSED_LOOKS:
                del self._open[key], self._unused[key]
                node.guard.run(f"closing {key[1]}", endpoint.close)
        if self._nodes:
            topics = self._host.get_topic_names_and_types()
            services = self._host.get_service_names_and_types()
            for is_service, found in ((False, topics), (True, services)):
                for name, _ in found:
                    self._consider(is_service, name)

    def _consider(self, is_service: bool, name: str) -> None:
        namespace, _, own = name.rpartition("/")
        asked = self._nodes.get(namespace)
        if asked is not None and (is_service, name) not in self._open:
            asked.guard.run(f"offering {name}", self._offer, asked, is_service, name, own)

    def _offer(self, node: AgentBase, is_service: bool, full_name: str, name: str) -> None:
        endpoint: Endpoint | None = node.endpoints.find(name, is_service=is_service)
        if endpoint is not None and endpoint.end is None and endpoint.is_asked_for(self._host):
            endpoint.open()
            self._open[is_service, full_name] = node, endpoint
