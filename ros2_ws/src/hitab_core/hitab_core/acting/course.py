"""The course of what an agent performs: its states in each cycle of the last minute.

It is kept before the agent acts on a percept, and only where something has changed. So an agent
can say what it did then, and can go back there when its world does.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from operator import attrgetter
from typing import Any, NamedTuple

from hitab_core.acting.draws import Draws
from hitab_core.running.run_context import Clock, Running
from hitab_core.training.past import PAST_SECONDS


class Moment(NamedTuple):
    """What an agent performed when it met a percept.

    Attributes:
        cycle: the world's cycle.
        time: simulated time, s.
        draws: how many random numbers it had drawn.
        memento: the states of all levels; see `Running.memento`.
    """

    cycle: int
    time: float
    draws: int
    memento: Any

    @property
    def active_path(self) -> list[str]:
        """Labels of the active states, outermost first."""
        path, inner = [], self.memento
        while inner is not None and isinstance(inner[0], str):
            path.append(inner[0])
            inner = inner[-1]
        return path


class Course:
    """Keeps the moments of the last minute at which something had changed."""

    def __init__(self, clock: Clock, draws: Draws) -> None:
        self._clock = clock
        self._draws = draws
        self._moments: list[Moment] = []
        self._running: Running | None = None
        self._noted = (-1, -1)
        self._again = False

    def note(self, cycle: int, running: Running | None) -> None:
        """Note what is performed when a percept is met, if that has changed."""
        if running is not self._running:
            self.forget()
            self._running = running
        noted = self._clock.changes, self._draws.count
        if noted == self._noted and not self._again:
            return
        # The first pulse of a one-shot behavior follows its start, and is no change of state.
        self._again, self._noted = noted != self._noted, noted
        if running is None:
            return
        moments = self._moments
        del moments[bisect_left(moments, cycle, key=attrgetter("cycle")) :]
        now = self._clock.now
        moments.append(Moment(cycle, now, self._draws.count, running.memento()))
        # The last moment before the minute tells what was performed when it began.
        old = bisect_right(moments, now - PAST_SECONDS, key=attrgetter("time"))
        del moments[: max(0, old - 1)]

    def at(self, cycle: int) -> Moment | None:
        """Return what was performed when the percept of a cycle was met; None if not known."""
        place = bisect_right(self._moments, cycle, key=attrgetter("cycle"))
        return self._moments[place - 1] if place else None

    def forget(self) -> None:
        """Forget all moments, as at the beginning of an episode."""
        self._moments = []
        self._noted = (-1, -1)

    def back(self, cycle: int) -> None:
        """Go back to a cycle: restore what was performed, and forget what came after.

        What began later than that is in Start; the agent's body is not restored.
        """
        moment, running = self.at(cycle), self._running
        if moment is not None and running is not None:
            running.restore(moment.memento)
            self._draws.back(moment.draws)
        elif running is not None:
            running.stop()
            running.start()
        del self._moments[bisect_left(self._moments, cycle, key=attrgetter("cycle")) :]
        self._noted = (-1, -1)
