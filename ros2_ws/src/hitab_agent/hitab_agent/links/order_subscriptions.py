"""Subscriptions to commanders' orders, shared by the agents of one process."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs import msg

from hitab_core.codec import from_dict
from hitab_core.orders import Order
from hitab_ros import GuardedNode, qos

Take = Callable[[Order], None]
Follow = Callable[[str, Order], None]


class OrderSubscriptions:
    """Subscribes to each commander once, and passes its orders to all its subordinates here.

    Decoding an order costs more than obeying it, so a process decodes each order once for a squad.
    """

    def __init__(self, node: GuardedNode) -> None:
        """Prepare to subscribe.

        Args:
            node: the node to subscribe on.
        """
        self._node = node
        self._takers: dict[str, list[Take]] = {}
        self._followers: dict[str, list[Follow]] = {}
        self._last: dict[str, Order] = {}

    def listen(self, node: GuardedNode, topic: str, take: Take) -> None:
        """Call ``take`` with the order in force, if there is one, and with each new order.

        Args:
            node: the listening agent's node, whose status shows a failure of ``take``.
            topic: the topic of a commander's orders.
            take: receives the orders.
        """
        take = node.guard.wrap(f"order on {topic}", take)
        if topic in self._takers:
            self._takers[topic].append(take)
            if topic in self._last:
                take(self._last[topic])
            return
        takers = self._takers[topic] = [take]

        def on_order(message: msg.Order) -> None:
            order = self._last[topic] = from_dict(Order, message, name=message.order)
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
