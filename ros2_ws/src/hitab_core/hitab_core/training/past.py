"""The last minute of a training as it was: the percepts to which a command may go back.

A person who has gone back in time commands for the percept that is shown. THE RULE: such a command
records, bit for bit, the example that it would have recorded if the world had stood still at that
percept, before the agent acted on it: from the state that was active then. Commands given later in
that course stay as they are: each says what to do in the state in which it was given. If nothing
was commanded, tested or taken over since that percept, the agent now performs the commanded
behavior, as after any late command; otherwise it continues with what it does.

`PerceptHistory` changes its percepts when a late command says that another state should have been
active. These here are never changed.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from operator import attrgetter

from hitab_core.texts.errors import TrainingError
from hitab_core.training.percepts import PerceptRecord

PAST_SECONDS = 60.0
"""Simulated time for which percepts are kept as they were: longer ago, nobody remembers why."""

CYCLE = attrgetter("cycle")
TIME = attrgetter("time")


class Past:
    """The percepts of the last minute, each with the state in which the agent met it.

    Attributes:
        kept: the percepts, oldest first; at most one for each cycle.
    """

    def __init__(self) -> None:
        self.kept: list[PerceptRecord] = []
        self._interventions: list[float] = []

    @property
    def intervened(self) -> float:
        """The time of the last intervention, s; -1 if there was none."""
        return max(self._interventions, default=-1.0)

    def intervene(self, time: float) -> None:
        """Note that somebody commanded for a percept, or tested or took over at it.

        Args:
            time: of the percept, s.
        """
        self._interventions.append(time)

    def add(self, percept: PerceptRecord, step: float) -> None:
        """Keep a percept, in place of those of its cycle and later ones.

        Args:
            percept: the percept.
            step: least time between kept percepts, s; of faster ones, some are left out.
        """
        kept = self.kept
        if len(kept) > 1 and kept[-1].time - kept[-2].time < step:
            kept.pop()
        while kept and (kept[-1].cycle >= percept.cycle or kept[-1].time > percept.time):
            kept.pop()
        kept.append(percept)
        if percept.time - kept[0].time > PAST_SECONDS:
            del kept[: bisect_right(kept, percept.time - PAST_SECONDS, key=TIME)]

    def forget(self) -> None:
        """Forget all percepts: none of them leads to the next one."""
        self.kept = []
        self._interventions = []

    def back(self, cycle: int) -> None:
        """Forget the percepts from a cycle on, which the world will show again."""
        del self.kept[bisect_left(self.kept, cycle, key=CYCLE) :]
        last = self.kept[-1].time if self.kept else -1.0
        self._interventions = [time for time in self._interventions if time <= last]

    def at(self, cycle: int) -> PerceptRecord:
        """Return the percept of a cycle; of a robot that is too fast to keep all, the one before.

        Raises:
            TrainingError: if it is not kept.
        """
        place = bisect_right(self.kept, cycle, key=CYCLE)
        if not place:
            first = f"begin at cycle {self.kept[0].cycle}" if self.kept else "are none"
            raise TrainingError(
                f"the percept of cycle {cycle} is not kept: a training keeps the last "
                f"{PAST_SECONDS:g} s of an episode, and its percepts {first}; choose a later one"
            )
        return self.kept[place - 1]

    def before(self, percept: PerceptRecord, seconds: float) -> list[PerceptRecord]:
        """Return the percepts of some time before a kept one, s, and that one."""
        end = bisect_right(self.kept, percept.cycle, key=CYCLE)
        return self.kept[bisect_left(self.kept, percept.time - seconds, key=TIME) : end]
