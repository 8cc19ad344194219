"""The topic of an agent's percepts, for recorders."""

from __future__ import annotations

from typing import Any

from hitab_msgs import msg

from hitab_agent.endpoints import PublishedTopic
from hitab_agent.node.agent_base import AgentBase
from hitab_ros import Receivers, names, qos
from hitab_ros.timing import POLL_S


class PerceptLog:
    """Publishes each percept that an agent takes in, while the topic has a subscriber.

    A new subscriber first gets the last percept again, since a paused world sends no other; from
    an agent in a host, it gets the next one.

    Attributes:
        topic: the topic, which is created only for a subscriber.
        is_on: whether it has to be told of percepts.
    """

    def __init__(self, node: AgentBase) -> None:
        """Prepare to publish."""
        self._node = node
        # A host reuses one object for the percepts of all agents, so it cannot be kept.
        self.is_on = self._keeps = node.shared.host is None
        self._receivers: Receivers | None = None
        self._last: Any = None
        self.topic = PublishedTopic(
            node, msg.Percept, names.PERCEIVED, qos.PERCEIVED, self._opened, self._closed
        )

    def tell(self, percept: msg.Percept) -> None:
        """Publish a percept that the agent is about to take in."""
        if self._keeps:
            self._last = percept
        if self._receivers is not None and self._receivers.count:
            self._publish(percept)

    def _opened(self) -> None:
        self.is_on = True
        self._receivers = Receivers(self._node, self.topic.end)
        self._stop = self._node.shared.scheduler.every(POLL_S, self._look, self._node.guard)

    def _closed(self) -> None:
        self.is_on, self._receivers = self._keeps, None
        self._stop()

    def _look(self) -> None:
        receivers, last = self._receivers, self._last
        if receivers is not None and receivers.look() and receivers.count and last is not None:
            self._publish(last)

    def _publish(self, percept: Any) -> None:
        """Publish a percept, which may be an object with the fields of the message."""
        fields = msg.Percept.get_fields_and_field_types()
        self.topic.publish(msg.Percept(**{field: getattr(percept, field) for field in fields}))
