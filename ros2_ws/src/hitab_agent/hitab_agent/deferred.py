"""Deferred calls that share one timer."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from hitab_ros import Guard, GuardedNode, name_of, steady_timer


class Deferred:
    """Makes deferred calls in order, a period later; the timer stops when none are left.

    The number of calls in a period can be limited, so that urgent work, such as an order, gets
    its turn in between.
    """

    def __init__(self, node: GuardedNode, period_s: float, at_most: int | None = None) -> None:
        """Create the timer, stopped.

        Args:
            node: owns the timer.
            period_s: between two turns, s.
            at_most: maximum number of calls in one turn; None: all.
        """
        self._at_most = at_most
        self._guard = node.guard
        self._calls: deque[tuple[Callable[[], None], Guard]] = deque()
        self._timer = steady_timer(node, period_s, self._due)
        self._timer.cancel()

    def call(self, call: Callable[[], None], guard: Guard | None = None) -> None:
        """Call a function soon.

        Args:
            call: the function.
            guard: of the agent whose status shows a failure; None: that of the node.
        """
        if not self._calls:
            self._timer.reset()
        self._calls.append((call, guard or self._guard))

    def _due(self) -> None:
        calls = self._calls
        due = len(calls) if self._at_most is None else min(self._at_most, len(calls))
        for _ in range(due):
            call, guard = calls.popleft()
            guard.run(name_of(call), call)
        if not calls:
            self._timer.cancel()
