"""The gate of a lockstep round: agents act only once their commanders have given orders."""

from __future__ import annotations

from collections.abc import Callable, Collection

from hitab_agent.links.order_exchange import Exchange
from hitab_core.orders import Order

Act = Callable[[], None]


class RoundGate:
    """Calls a function in each round once all commanders have given their order for the round.

    After a missed round, the gate does not wait for that commander until its next order, or until
    the first round after look-only ones, in which agents perceive and do not act. So a run without
    the commander misses at least one deadline, which marks the run as not reproducible. A
    restarted commander has lost its state, so it must miss a deadline too, however fast it
    restarts. No clock is involved: a round is over when the next begins.
    """

    def __init__(self, exchange: Exchange) -> None:
        self._exchange = exchange
        self._round = 0
        self._act: Act | None = None
        self._awaited: set[str] = set()
        self._silent: set[str] = set()
        self._last_round: dict[str, int] = {}
        self._epochs: dict[str, int] = {}
        self._restarted: set[str] = set()  # and has missed no deadline since
        self._last_was_look = True

    def begin(self, number: int, commanders: Collection[str], act: Act, *, look: bool) -> None:
        """Begin a round; a function that still waits from the previous round is not called.

        Args:
            number: the round's number.
            commanders: the commanders whose orders to wait for.
            act: called when these orders have come; at once if there are none.
            look: whether the round is look-only.
        """
        if self._last_was_look and not look:
            self._silent.clear()
        elif self._act is not None:
            self._silent |= self._awaited - self._restarted
            self._restarted -= self._awaited
        if look or self._last_was_look:
            self._restarted.clear()
        self._last_was_look = look
        self._act = None
        for commander in commanders:
            if commander not in self._last_round:
                self._last_round[commander] = 0
                self._exchange.follow(commander, self._hear)
        self._awaited = {
            commander
            for commander in commanders
            if commander not in self._silent
            and (self._last_round[commander] != number or commander in self._restarted)
        }
        self._round, self._act = number, act
        self._act_if_complete()

    def _hear(self, commander: str, order: Order) -> None:
        if order.epoch != self._epochs.setdefault(commander, order.epoch):
            self._epochs[commander] = order.epoch
            self._restarted.add(commander)
        self._silent.discard(commander)
        self._last_round[commander] = order.round
        if order.round == self._round and commander not in self._restarted:
            self._awaited.discard(commander)
            self._act_if_complete()

    def _act_if_complete(self) -> None:
        act = self._act
        if act is not None and not self._awaited:
            self._act = None
            act()
