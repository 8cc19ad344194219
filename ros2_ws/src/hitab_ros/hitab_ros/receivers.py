"""Receivers of a node's messages, and the arrival of new ones."""

from __future__ import annotations

from typing import Any

from rclpy.node import Node


class Receivers:
    """Receivers of a publisher.

    Their number alone does not show that a new receiver has replaced another, as when a restarted
    process appears at the moment at which its killed predecessor is dropped.

    Attributes:
        count: number of connected receivers at the last look.
    """

    def __init__(self, node: Node, publisher: Any) -> None:
        """Start without receivers.

        Args:
            node: node of the publisher.
            publisher: publisher from which they receive.
        """
        self.count = 0
        self._node = node
        self._publisher = publisher
        self._ends: frozenset[bytes] = frozenset()

    def look(self) -> bool:
        """Update the receivers; return whether one of them is new.

        A killed process is dropped long after its successor has started; this is not a change.
        """
        count, ends = self.count, self._ends
        found = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
        # A receiver may be discovered before it is connected, so both are compared.
        self._ends = frozenset(bytes(end.endpoint_gid) for end in found)
        self.count = self._publisher.get_subscription_count()
        return self.count > count or not self._ends <= ends
