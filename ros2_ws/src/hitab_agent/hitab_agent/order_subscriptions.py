"""Receiving the orders of commanders for all agents of one process."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs import msg

from hitab_core.orders import Order
from hitab_ros import GuardedNode, qos
from hitab_ros.conversions import order_of

Take = Callable[[Order], None]
Follow = Callable[[str, Order], None]


class OrderSubscriptions:
    """Subscribes to each commander once, and hands its orders to all its subordinates.

    Reading an order costs more than obeying it, so a squad in one process reads each order once.
    """

    def __init__(self, node: GuardedNode) -> None:
        """Subscribe to nothing yet.

        Args:
            node: to subscribe on.
        """
        self._node = node
        self._takers: dict[str, list[Take]] = {}
        self._followers: dict[str, list[Follow]] = {}
        self._last: dict[str, Order] = {}

    def listen(self, node: GuardedNode, topic: str, take: Take) -> None:
        """Call ``take`` with the order in force, if there is one, and with each new one.

        Args:
            node: of the agent that listens; its status shows a failure of ``take``.
            topic: of a commander's orders.
            take: receives them.
        """
        take = node.guard.wrap(f"order on {topic}", take)
        if topic in self._takers:
            self._takers[topic].append(take)
            if topic in self._last:
                take(self._last[topic])
            return
        takers = self._takers[topic] = [take]

        def on_order(message: msg.Order) -> None:
            order = self._last[topic] = order_of(message)
            for taker in takers:
                taker(order)
            for follow in self._followers.get(topic, ()):
                follow(topic, order)

        self._node.create_subscription(msg.Order, topic, on_order, qos.LATCHED)

    def follow(self, topic: str, follow: Follow) -> None:
        """Call ``follow`` with each order on a topic after all subordinates have received it."""
        self._followers.setdefault(topic, []).append(
            self._node.guard.wrap(f"round of {topic}", follow)
        )
