"""Holding back what agents do in a round of lockstep until their commanders have spoken."""

from __future__ import annotations

from collections.abc import Callable, Collection

from hitab_agent.order_subscriptions import OrderSubscriptions
from hitab_core.commanding import Order

Act = Callable[[], None]


class RoundGate:
    """Calls a function in each round, when all commanders have given their order of the round.

    A commander that lets a round pass is not waited for until it is heard again. No clock takes
    part: a round has passed when the next one begins.
    """

    def __init__(self, orders: OrderSubscriptions) -> None:
        self._orders = orders
        self._round = 0
        self._act: Act | None = None
        self._awaited: set[str] = set()
        self._silent: set[str] = set()
        self._spoken: dict[str, int] = {}

    def begin(self, number: int, commanders: Collection[str], act: Act) -> None:
        """Begin a round; what was held back in the one before is not done any more.

        Args:
            number: of the round.
            commanders: the topics of the orders to wait for.
            act: what to do then, at once if there is nobody to wait for.
        """
        if self._act is not None:
            self._silent |= self._awaited
        for commander in commanders:
            if commander not in self._spoken:
                self._spoken[commander] = 0
                self._orders.follow(commander, self._hear)
        self._awaited = {
            commander
            for commander in commanders
            if commander not in self._silent and self._spoken[commander] != number
        }
        self._round, self._act = number, act
        self._go_on()

    def _hear(self, commander: str, order: Order) -> None:
        self._silent.discard(commander)
        self._spoken[commander] = order.round
        if order.round == self._round:
            self._awaited.discard(commander)
            self._go_on()

    def _go_on(self) -> None:
        act = self._act
        if act is not None and not self._awaited:
            self._act = None
            act()
