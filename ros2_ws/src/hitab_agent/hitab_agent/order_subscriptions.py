"""Hearing the orders of commanders on behalf of all agents of one process."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs import msg

from hitab_core.commanding import Order
from hitab_ros import GuardedNode, qos
from hitab_ros.conversions import order_of

Take = Callable[[Order], None]
Follow = Callable[[str, Order], None]


class OrderSubscriptions:
    """Has one subscription for each commander and hands its orders to all who are under it.

    Orders pass down through a process as fast as it can read them, and reading one costs more
    than obeying it: a squad that lives in one process reads once.
    """

    def __init__(self, node: GuardedNode) -> None:
        """Make it.

        Args:
            node: to subscribe on.
        """
        self._node = node
        self._takers: dict[str, list[Take]] = {}
        self._followers: dict[str, list[Follow]] = {}
        self._last: dict[str, Order] = {}

    def listen(self, node: GuardedNode, topic: str, take: Take) -> None:
        """Call ``take`` with the order in force, if one was heard, and with all that come.

        Args:
            node: of the agent that listens, in whose status a failure of ``take`` is shown.
            topic: of a commander's orders.
            take: what to do with them.
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
        """Call ``follow`` with each order on a topic when all who are under it have taken it."""
        self._followers.setdefault(topic, []).append(
            self._node.guard.wrap(f"round of {topic}", follow)
        )
