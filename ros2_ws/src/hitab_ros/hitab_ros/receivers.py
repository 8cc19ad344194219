"""Notices who receives what a node publishes."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node


class Receivers:
    """Receivers of a publisher.

    Their number alone does not tell that one has taken the place of another, as a restarted
    process does when the killed one is given up at the same moment.

    Attributes:
        count: how many were connected at the last look.
    """

    def __init__(self, node: Node, publisher: Any) -> None:
        """Know of none yet.

        Args:
            node: of the publisher.
            publisher: from which they receive.
        """
        self.count = 0
        self._node = node
        self._publisher = publisher
        self._ends: frozenset[bytes] = frozenset()

    def look(self) -> bool:
        """Update the receivers; return whether one of them is new.

        A killed process is given up long after another has taken its place: that is no news.
        """
        count, ends = self.count, self._ends
        found = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
        # One may be known a moment before it is connected, so both are compared.
        self._ends = frozenset(bytes(end.endpoint_gid) for end in found)
        self.count = self._publisher.get_subscription_count()
        return self.count > count or not self._ends <= ends
