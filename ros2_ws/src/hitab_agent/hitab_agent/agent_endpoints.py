"""The topics and services of an agent's node for demonstrators and observers."""

from __future__ import annotations

from collections.abc import Sequence

from rclpy.parameter_service import ParameterService

from hitab_agent.agent_services import AgentServices, command_topic
from hitab_agent.endpoints import Endpoint
from hitab_agent.inspection_services import InspectionServices
from hitab_agent.node.agent_base import AgentBase
from hitab_ros.timing import POLL_S


class AgentEndpoints:
    """Opens the endpoints of an agent: all at once, or those that somebody asks for.

    Attributes:
        topics: the topics.
    """

    def __init__(self, node: AgentBase) -> None:
        """Prepare the endpoints of a node; none is opened yet."""
        self._node = node
        self.topics: list[Endpoint] = [
            node.status.topic,
            command_topic(node),
            node.transition_log.topic,
            node.training.topic,
        ]
        self._services: dict[str, Endpoint] | None = None

    @property
    def services(self) -> dict[str, Endpoint]:
        """The services, by name."""
        if self._services is None:  # few agents of a host are ever asked for one
            parts = AgentServices(self._node), InspectionServices(self._node, self._node.agent)
            self._services = {one.short_name: one for part in parts for one in part.endpoints}
        return self._services

    def find(self, name: str, *, is_service: bool) -> Sequence[Endpoint]:
        """Return the topics or services with a name relative to the node."""
        if is_service:
            return [self.services[name]] if name in self.services else []
        topics = [*self.topics, self._node.percept_log.topic]
        return [topic for topic in topics if topic.short_name == name]

    def offer(self) -> None:
        """Open all endpoints, or begin to look for those that somebody asks for.

        A process of one agent always has all topics.
        """
        node, shared = self._node, self._node.shared
        if shared.on_demand is not None:
            shared.on_demand.add(node)
        else:
            for service in self.services.values():
                service.open()
        if shared.on_demand is None or shared.host is None:
            shared.scheduler.every(POLL_S, self._offer_percepts, node.guard)
            for topic in self.topics:
                topic.open()
        if shared.host is None:
            ParameterService(node)

    def _offer_percepts(self) -> None:
        if (topic := self._node.percept_log.topic).is_asked_for(self._node):
            topic.open()
