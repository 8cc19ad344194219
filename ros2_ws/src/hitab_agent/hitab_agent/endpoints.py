"""Endpoints of an agent's node: topics and services that it creates at once, or for those who ask.

DDS announces each endpoint to every process of the swarm. An agent has some thirty, of which few
are used: a thousand agents would take minutes to start and gigabytes to run.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile

from hitab_ros import GuardedNode


def _nothing() -> None:
    pass


class Endpoint:
    """A topic or service of a node, by its name relative to the node.

    Attributes:
        node: the node.
        short_name: its name relative to the node.
        end: the publisher, subscription or service; None while there is none.
        mirror: the node's own endpoint at the other end, which does not count as somebody else.
    """

    __slots__ = ("end", "mirror", "node", "short_name")

    def __init__(self, node: GuardedNode, name: str) -> None:
        self.node = node
        self.short_name = name
        self.end: Any = None
        self.mirror: Endpoint | None = None

    @property
    def name(self) -> str:
        """The full name."""
        return str(self.node.resolve_topic_name(self.short_name))

    def open(self) -> None:
        """Create the publisher, subscription or service, unless it is there."""
        if self.end is None:
            self.end = self._create()

    def close(self) -> None:
        """Destroy it, unless it was."""
        end, self.end = self.end, None
        if end is not None:
            self._destroy(end)

    def repeat(self, observer: Node) -> None:
        """Send again what is latched, to those who may have missed it."""

    def is_asked_for(self, observer: Node) -> bool:
        """Whether somebody has an endpoint at the other end, as a node sees the ROS graph."""
        return self._others(observer) > self._own

    @property
    def _own(self) -> int:
        return int(self.mirror is not None and self.mirror.end is not None)

    def _others(self, observer: Node) -> int:
        raise NotImplementedError

    def _create(self) -> Any:
        raise NotImplementedError

    def _destroy(self, end: Any) -> None:
        raise NotImplementedError


class PublishedTopic(Endpoint):
    """A topic that a node publishes.

    Args:
        node: the node.
        kind: type of the messages.
        name: name of the topic.
        profile: QoS profile.
        opened: called when the publisher was created.
        closed: called when it was destroyed.
        latched: publishes what is latched.
    """

    __slots__ = ("_closed", "_kind", "_latched", "_opened", "_profile")

    def __init__(
        self,
        node: GuardedNode,
        kind: Any,
        name: str,
        profile: QoSProfile,
        opened: Callable[[], object] = _nothing,
        closed: Callable[[], object] = _nothing,
        latched: Callable[[], object] = _nothing,
    ) -> None:
        super().__init__(node, name)
        self._kind, self._profile = kind, profile
        self._opened, self._closed, self._latched = opened, closed, latched

    def open(self) -> None:
        """Create the publisher, unless it is there."""
        if self.end is None:
            super().open()
            self._opened()
            self._latched()

    def close(self) -> None:
        """Destroy the publisher, unless it was."""
        if self.end is not None:
            super().close()
            self._closed()

    def repeat(self, observer: Node) -> None:
        """Publish again what is latched, if a subscriber does not ask for earlier messages."""
        others = observer.get_subscriptions_info_by_topic(self.name)
        if any(one.qos_profile.durability != DurabilityPolicy.TRANSIENT_LOCAL for one in others):
            self._latched()

    def publish(self, message: Any) -> None:
        """Publish a message, if there is a publisher."""
        if self.end is not None:
            self.end.publish(message)

    @property
    def is_listened_to(self) -> bool:
        """Whether there is a publisher with subscribers."""
        return self.end is not None and self.end.get_subscription_count() > self._own

    def _others(self, observer: Node) -> int:
        return observer.count_subscribers(self.name)

    def _create(self) -> Any:
        return self.node.create_publisher(
            self._kind, self.short_name, self._profile, temporary=True
        )

    def _destroy(self, end: Any) -> None:
        self.node.destroy_publisher(end)


class HeardTopic(Endpoint):
    """A topic to which a node subscribes.

    Args:
        node: the node.
        kind: type of the messages.
        name: name of the topic.
        profile: QoS profile.
        take: receives the messages.
        checked: whether invalid messages are dropped.
    """

    __slots__ = ("_checked", "_kind", "_profile", "_take")

    def __init__(
        self,
        node: GuardedNode,
        kind: Any,
        name: str,
        profile: QoSProfile,
        take: Callable[[Any], object],
        *,
        checked: bool = True,
    ) -> None:
        super().__init__(node, name)
        self._kind, self._profile, self._take, self._checked = kind, profile, take, checked

    def _others(self, observer: Node) -> int:
        return observer.count_publishers(self.name)

    def _create(self) -> Any:
        return self.node.create_subscription(
            self._kind,
            self.short_name,
            self._take,
            self._profile,
            checked=self._checked,
            temporary=True,
        )

    def _destroy(self, end: Any) -> None:
        self.node.destroy_subscription(end)


class OfferedService(Endpoint):
    """A service of a node."""

    __slots__ = ("_kind", "_serve")

    def __init__(
        self, node: GuardedNode, kind: Any, name: str, serve: Callable[[Any, Any], Any]
    ) -> None:
        super().__init__(node, name)
        self._kind, self._serve = kind, serve

    def _others(self, observer: Node) -> int:
        return observer.count_clients(self.name)

    def _create(self) -> Any:
        return self.node.create_service(self._kind, self.short_name, self._serve)

    def _destroy(self, end: Any) -> None:
        self.node.destroy_service(end)
