"""A basic behavior being performed by one agent."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from hitab_core.action_behavior import ActionBehavior, ActionCall, calls_of, goal_of
from hitab_core.domain import BasicBehavior, Domain
from hitab_core.number import numbers_of, without_numbers
from hitab_core.running.feature_cache import resolved
from hitab_core.term import Term


class RunningBasicBehavior:
    """A basic behavior being performed; a one-shot one pulses once per start."""

    __slots__ = ("_one_shot", "_pulse", "_pulsed", "_start", "_stop", "raised")

    def __init__(self, domain: Domain, body: Any, behavior: BasicBehavior, term: Term) -> None:
        self._start = resolved(behavior.start, body, domain, term)
        self._pulse = resolved(behavior.pulse, body, domain, term)
        self._stop = resolved(behavior.stop, body, domain, term)
        self._one_shot = behavior.one_shot
        self._pulsed = False
        self.raised: set[str] = set()

    @property
    def active_path(self) -> list[str]:
        """Nothing: a basic behavior has no states."""
        return []

    def start(self) -> None:
        """Start performing."""
        self._pulsed = False
        self._start()

    def tick(self) -> None:
        """Pulse once; a one-shot behavior only the first time."""
        if self._one_shot:
            if self._pulsed:
                return
            self._pulsed = True
        self._pulse()

    def stop(self) -> None:
        """Stop performing."""
        self._stop()

    def memento(self) -> tuple[Any, ...]:
        """Return what a pulse depends on; see `Running.memento`."""
        return self._pulsed, frozenset(self.raised)

    def restore(self, memento: Any) -> None:
        """Restore it."""
        self._pulsed = memento[0]
        self.raised.clear()
        self.raised.update(memento[1])


class RunningWithNumbers(RunningBasicBehavior):
    """A basic behavior that takes numbers; it does nothing while it has none.

    Attributes:
        numbers: numbers for the next pulse, or empty.
    """

    __slots__ = ("_halted", "numbers")

    def __init__(self, domain: Domain, body: Any, behavior: BasicBehavior, term: Term) -> None:
        targets = without_numbers(term)
        self.numbers = () if targets == term else numbers_of(term, behavior.numbers)
        self._halted = False

        def pulse(body: Any, *targets: Any) -> None:
            behavior.pulse(body, *targets, *self.numbers)

        super().__init__(domain, body, replace(behavior, pulse=pulse), targets)

    def start(self) -> None:
        """Start performing."""
        self._halted = False
        super().start()

    def give(self, numbers: tuple[float, ...]) -> None:
        """Continue with these numbers."""
        if self._halted:
            self._halted = False
            self._start()  # a one-shot behavior does not pulse again
        self.numbers = numbers

    def halt(self) -> None:
        """Stop until numbers are given again."""
        self.stop()
        self.numbers, self._halted = (), True

    def tick(self) -> None:
        """Pulse once, if there are numbers."""
        if self.numbers:
            super().tick()

    def stop(self) -> None:
        """Stop performing."""
        if not self._halted:
            super().stop()

    def memento(self) -> tuple[Any, ...]:
        """Return what a pulse depends on, with the numbers."""
        return *super().memento(), self.numbers

    def restore(self, memento: Any) -> None:
        """Restore it; halted behaviors are given numbers again, or not, by the next decision."""
        super().restore(memento)
        if memento[2]:
            self.give(memento[2])


class RunningAction(RunningBasicBehavior):
    """An action being performed by its server; see `ActionBehavior`.

    The goal is sent with the first pulse, not at the start: then there is a percept to make it
    of, and nothing happens while a simulated world is paused.
    """

    __slots__ = ("_behavior", "_call", "_calls", "_goal", "_use")

    def __init__(self, domain: Domain, body: Any, behavior: ActionBehavior, term: Term) -> None:
        super().__init__(domain, body, behavior, term)
        self._behavior = behavior
        self._use = term
        self._calls = calls_of(body)
        self._call: ActionCall | None = None
        self._goal = resolved(
            lambda body, *targets: goal_of(behavior, body, targets), body, domain, term
        )

    def start(self) -> None:
        """Start performing, with no flag raised."""
        self.raised.clear()
        super().start()

    def tick(self) -> None:
        """Pulse once; send the goal if that has not happened yet, raise a flag if it is over."""
        super().tick()
        call = self._call
        if call is None:
            call = self._call = self._calls.begin(self._behavior, self._use, self._goal)
        call.pulses += 1
        if call.outcome:
            self.raised.add(call.outcome)

    def stop(self) -> None:
        """Cancel the goal, unless it is over; stop performing."""
        call, self._call = self._call, None
        if call is not None:
            self._calls.leave(call)
        super().stop()
