"""Holding back the actions of a lockstep round until the commanders have given their orders."""

from __future__ import annotations

from collections.abc import Callable, Collection

from hitab_agent.order_subscriptions import OrderSubscriptions
from hitab_core.orders import Order

Act = Callable[[], None]


class RoundGate:
    """Calls a function in each round once all commanders have given their order for it.

    A commander that misses a round is not waited for until its next order, or until a round is
    played after one of looking: a run without a commander must miss a deadline, which marks the
    run. A restart of a commander, however fast, must miss one too: the state is lost. No clock is
    involved: a round is over when the next begins.
    """

    def __init__(self, orders: OrderSubscriptions) -> None:
        self._orders = orders
        self._round = 0
        self._act: Act | None = None
        self._awaited: set[str] = set()
        self._silent: set[str] = set()
        self._last_round: dict[str, int] = {}
        self._epochs: dict[str, int] = {}
        self._restarted: set[str] = set()  # since then, no deadline was missed
        self._last_was_look = True

    def begin(self, number: int, commanders: Collection[str], act: Act, *, look: bool) -> None:
        """Begin a round; drop what was held back in the previous one.

        Args:
            number: of the round.
            commanders: the topics of the orders to wait for.
            act: called then; at once if there is no order to wait for.
            look: whether agents only look in it.
        """
        if self._last_was_look and not look:
            self._silent.clear()
        elif self._act is not None:
            self._silent |= self._awaited - self._restarted
            self._restarted -= self._awaited
        if look or self._last_was_look:
            self._restarted.clear()
        self._last_was_look = look
        for commander in commanders:
            if commander not in self._last_round:
                self._last_round[commander] = 0
                self._orders.follow(commander, self._hear)
        self._awaited = {
            commander
            for commander in commanders
            if commander not in self._silent
            and (self._last_round[commander] != number or commander in self._restarted)
        }
        self._round, self._act = number, act
        self._go_on()

    def _hear(self, commander: str, order: Order) -> None:
        if order.epoch != self._epochs.setdefault(commander, order.epoch):
            self._epochs[commander] = order.epoch
            self._restarted.add(commander)
        self._silent.discard(commander)
        self._last_round[commander] = order.round
        if order.round == self._round and commander not in self._restarted:
            self._awaited.discard(commander)
            self._go_on()

    def _go_on(self) -> None:
        act = self._act
        if act is not None and not self._awaited:
            self._act = None
            act()
