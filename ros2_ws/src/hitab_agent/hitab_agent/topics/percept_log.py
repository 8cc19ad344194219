"""The topic of an agent's percepts, for recorders."""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_ros import Receivers, names, qos
from hitab_ros.timing import POLL_S


class PerceptLog:
    """Publishes each percept that an agent takes in, while the topic has a subscriber.

    A new subscriber first gets the last percept again, since a paused world sends no other.
    """

    def __init__(self, node: AgentBase) -> None:
        """Begin to look for subscribers, unless the agent runs in a host."""
        self._node = node
        self._publisher: Any = None
        self._receivers: Receivers | None = None
        self._last: msg.Percept | None = None
        if node.shared.host is None:
            node.shared.scheduler.every(POLL_S, self._look, node.guard)

    def tell(self, percept: msg.Percept) -> None:
        """Publish a percept that the agent is about to take in."""
        self._last = percept
        if self._receivers is not None and self._receivers.count:
            self._publish(percept)

    def _look(self) -> None:
        if self._receivers is None:
            if not self._node.count_subscribers(names.PERCEIVED):
                return
            self._publisher = self._node.create_publisher(
                msg.Percept, names.PERCEIVED, qos.PERCEIVED
            )
            self._receivers = Receivers(self._node, self._publisher)
        if self._receivers.look() and self._receivers.count and self._last is not None:
            self._publish(self._last)

    def _publish(self, percept: Any) -> None:
        """Publish a percept, which may be an object with the fields of the message."""
        fields = msg.Percept.get_fields_and_field_types()
        self._publisher.publish(
            msg.Percept(**{field: getattr(percept, field) for field in fields})
        )
