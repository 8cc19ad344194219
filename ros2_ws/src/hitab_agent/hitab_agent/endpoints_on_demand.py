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

REPEATING_LOOKS = 4
"""Looks at which a new topic repeats what is latched: ``ros2 topic echo`` does not ask for earlier
messages of a topic without a publisher, and misses what is sent before it has discovered one."""


class EndpointsOnDemand:
    """Opens and closes the endpoints of a process's agents."""

    def __init__(self, host: GuardedNode, scheduler: Scheduler, *, topics: bool = True) -> None:
        """Begin to look for the other ends.

        Args:
            host: the node whose view of the ROS graph is used.
            scheduler: the process's scheduler.
            topics: whether topics are opened and closed too. To list them costs more, the more
                processes of their own there are.
        """
        self._host = host
        self._topics = topics
        self._nodes: dict[str, AgentBase] = {}  # by namespace
        self._unused: dict[Endpoint, int] = {}  # looks since the last use of those that are open
        self._new: dict[Endpoint, int] = {}  # looks since they were opened
        scheduler.every(POLL_S, self.look)

    def add(self, node: AgentBase) -> None:
        """Look for those who ask for endpoints of an agent from now on."""
        self._nodes[node.get_namespace()] = node

    def look(self) -> None:
        """Open what is asked for, and close what has not been used for a while."""
        for endpoint in [*self._new]:
            self._new[endpoint] += 1
            if self._new[endpoint] >= REPEATING_LOOKS:
                del self._new[endpoint]
            endpoint.node.guard.run(endpoint.short_name, endpoint.repeat, self._host)
        for endpoint in [*self._unused]:
            unused = 0 if endpoint.is_asked_for(self._host) else self._unused[endpoint] + 1
            self._unused[endpoint] = unused
            if unused > UNUSED_LOOKS:
                del self._unused[endpoint]
                endpoint.node.guard.run(f"closing {endpoint.short_name}", endpoint.close)
        if self._nodes:
            topics = self._host.get_topic_names_and_types() if self._topics else ()
            services = self._host.get_service_names_and_types()
            for is_service, found in ((False, topics), (True, services)):
                for full_name, _ in found:
                    namespace, _, name = full_name.rpartition("/")
                    if (node := self._nodes.get(namespace)) is not None:
                        node.guard.run(f"offering {name}", self._offer, node, name, is_service)

    def _offer(self, node: AgentBase, name: str, is_service: bool) -> None:
        for endpoint in node.endpoints.find(name, is_service=is_service):
            if endpoint.end is None and endpoint.is_asked_for(self._host):
                endpoint.open()
                self._unused[endpoint] = self._new[endpoint] = 0
