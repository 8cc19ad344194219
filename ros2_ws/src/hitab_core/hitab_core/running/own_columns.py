"""The flags and timers of one automaton that many agents perform, on arrays.

They follow the same rules as `RunningAutomaton`'s, see `hitab_core.automaton.OWN_FEATURES`.
"""

from __future__ import annotations

import numpy as np

from hitab_core.arrays import Floats, Integers
from hitab_core.automaton import FLAGS, OWN_NAMES
from hitab_core.running.batch_senses import BatchSenses
from hitab_core.running.running_automaton import Level
from hitab_core.use import Use

FLAG_BITS = {flag: 1 << i for i, flag in enumerate(FLAGS)}


class OwnColumns:
    """What the agents' automata have raised and seen, and since when.

    Attributes:
        raised: shape (n,), the flags that each agent's automaton has raised, as bits.
        timed: whether there are timers; only then are times kept.
        asked: whether there are flags or timers among the automaton's features.
    """

    def __init__(self, size: int, senses: BatchSenses) -> None:
        self.raised = np.zeros(size, np.uint8)
        self.timed = self.asked = False
        self._senses = senses
        self._entered: Floats = np.zeros(size)
        self._seen: dict[str, Floats] = {flag: np.zeros(size) for flag in FLAGS}
        self._flag_slots: list[tuple[int, int]] = []
        self._timer_slots: list[tuple[int, str]] = []

    def slot(self, feature: Use) -> int | None:
        """Return a new slot for a flag or timer; None for a feature of the domain."""
        if feature.name not in OWN_NAMES:
            return None
        slot = self._senses.own_slot()
        if feature.name in FLAGS:
            self._flag_slots.append((slot, FLAG_BITS[feature.name]))
        else:
            self._timer_slots.append((slot, "".join(feature.arguments)))
            self.timed = True
        self.asked = True
        return slot

    def start(self, rows: Integers, now: Floats) -> None:
        """Lower the flags of some agents' automata and set their timers to zero."""
        self.raised[rows] = 0
        if self.timed:
            self._entered[rows] = now[rows]
            for times in self._seen.values():
                times[rows] = now[rows]

    def enter(self, rows: Integers, now: Floats) -> None:
        """Note that some agents have entered a state."""
        if self.timed:
            self._entered[rows] = now[rows]

    def query(self, child: OwnColumns | None, rows: Integers, now: Floats, *, blank: bool) -> None:
        """Fill in the flags and timers; a flag that was seen goes down.

        Args:
            child: of the automaton that the agents perform in their active state, if it is one.
            rows: the agents.
            now: shape (n,), the time of each agent, s.
            blank: whether they are in Start.
        """
        put = self._senses.put
        raised = np.zeros(len(rows), np.uint8) if child is None else child.raised[rows]
        if child is not None:
            child.raised[rows] = 0
        for slot, bit in self._flag_slots:
            put(slot, rows, (raised & bit) != 0)
        if self.timed:
            for flag, bit in FLAG_BITS.items():
                up = rows[(raised & bit) != 0]
                self._seen[flag][up] = now[up]
            for slot, flag in self._timer_slots:
                since = self._seen[flag] if flag else now if blank else self._entered
                put(slot, rows, np.maximum(0.0, now[rows] - since[rows]))

    def value(self, use: Use, row: int, raised: set[str], now: float, *, blank: bool) -> float:
        """Return the current value of one agent's flag or timer; leave flags up.

        Args:
            use: the feature.
            row: the agent.
            raised: flags that its active state's behavior has raised.
            now: its time, s.
            blank: whether it is in Start or in a flag state.
        """
        if use.name in FLAGS:
            return float(use.name in raised)
        flag = "".join(use.arguments)
        if (flag in raised) if flag else blank:
            return 0.0
        since = self._seen[flag] if flag else self._entered
        return max(0.0, now - float(since[row]))

    def raised_by(self, row: int) -> set[str]:
        """Return the flags that one agent's automaton has raised."""
        raised = int(self.raised[row])
        return {flag for flag, bit in FLAG_BITS.items() if raised & bit}

    def condition(self, row: int, active: int) -> Level:
        """Return one agent's condition; ``active`` is the index of its active state."""
        seen = {flag: float(times[row]) for flag, times in self._seen.items()}
        raised = frozenset(self.raised_by(row))
        return Level(active, raised, float(self._entered[row]), seen)

    def go_on_from(self, row: int, level: Level) -> None:
        """Restore one agent's condition."""
        self.raised[row] = sum(FLAG_BITS[flag] for flag in level.raised)
        self._entered[row] = level.entered
        for flag, time in level.seen.items():
            self._seen[flag][row] = time
