"""Percepts of an agent in training in the last seconds, so that a command can come late.

A person needs time to react, so the situation that a command is meant for is already past when the
command arrives. The agent keeps its last percepts, as readings of everything readable,
with the state that was active. A command that says how long ago it was due is recorded with the
situation of that time.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from hitab_core.automaton import FLAGS, OWN_FEATURES, START
from hitab_core.domain import Domain
from hitab_core.errors import TrainingError
from hitab_core.example_codec import value_records, values_of
from hitab_core.use import Use

KEPT_SECONDS = 10.0
"""Simulated time for which percepts are kept."""

WINDOW_SECONDS = 2.0
"""Minimum time before its command for which percepts stay with an example."""

WINDOW_MAX = 50
"""The most moments that stay with an example."""

STEP_SECONDS = 0.02
"""Moments that follow each other faster are not all kept."""

READABLE_MAX = 500
"""With more readings, features of two and more parameters are left out."""


@dataclass(frozen=True, slots=True)
class PerceptRecord:
    """One percept of an agent in training.

    Attributes:
        cycle: of the world.
        time: simulated time, s.
        state: label of the state that was active, or, once a command was due before, would have
            been active had it come in time.
        readings: see `readable`.
    """

    cycle: int
    time: float
    state: str
    readings: tuple[float, ...]

    def to_record(self) -> dict[str, Any]:
        """Return it as plain data for the journal."""
        return {
            "cycle": self.cycle,
            "time": self.time,
            "state": self.state,
            "readings": value_records(self.readings),
        }

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> PerceptRecord:
        """Read what `to_record` wrote."""
        return cls(
            int(record["cycle"]),
            float(record["time"]),
            str(record["state"]),
            values_of(record["readings"]),
        )


def readable(domain: Domain, parameters: Sequence[str]) -> tuple[Use, ...]:
    """Return what can be read in every moment: the domain's features, flags and timers.

    Features of the domain are read for all targets and parameters.

    Args:
        domain: of the agent.
        parameters: of the automaton in training.
    """
    things = [*sorted(domain.targets), *parameters]
    features = sorted(domain.features.values(), key=lambda feature: feature.name)
    if sum(len(things) ** len(f.parameters) for f in features) > READABLE_MAX:
        features = [feature for feature in features if len(feature.parameters) < 2]
    uses = [
        Use(feature.name, arguments)
        for feature in features
        for arguments in product(things, repeat=len(feature.parameters))
    ]
    return (*uses, *OWN_FEATURES)


class RecentPercepts:
    """The last moments of an agent in training, oldest first.

    They never reach back beyond a jump: a new episode, or a change of a paused world.
    """

    def __init__(self) -> None:
        self._kept: list[PerceptRecord] = []

    @property
    def latest(self) -> PerceptRecord | None:
        """The last moment; None if there is none."""
        return self._kept[-1] if self._kept else None

    def add(self, moment: PerceptRecord) -> None:
        """Keep a moment, unless it follows the last but one too fast; drop those too old."""
        kept = self._kept
        if kept and moment.time < kept[-1].time:
            kept.clear()  # the world's clock was set back
        if len(kept) > 1 and kept[-1].time - kept[-2].time < STEP_SECONDS:
            kept.pop()
        kept.append(moment)
        if moment.time - kept[0].time > KEPT_SECONDS:
            first = bisect_right(kept, moment.time - KEPT_SECONDS, key=lambda m: m.time)
            del kept[:first]

    def due(self, ago: float, seen: int = 0) -> PerceptRecord:
        """Return the moment nearest to when a command was due.

        Args:
            ago: how long before what the demonstrator saw, s of simulated time.
            seen: the world's cycle that the demonstrator saw; 0 for the last one.

        Raises:
            TrainingError: if that is in the future, or longer ago than is kept.
        """
        if not 0.0 <= ago <= KEPT_SECONDS:
            raise TrainingError(
                f"a command cannot have been due {ago:g} s ago: the agent keeps the last "
                f"{KEPT_SECONDS:g} s; give a number from 0 to {KEPT_SECONDS:g}"
            )
        kept = self._kept
        if not kept:
            raise TrainingError(
                f"nothing was perceived {ago:g} s ago; command without saying when it was due"
            )
        base = kept[-1].time
        if seen and seen < kept[0].cycle and kept[-1].time - kept[0].time > KEPT_SECONDS / 2:
            raise TrainingError(
                f"cycle {seen} was more than {KEPT_SECONDS:g} s ago, and the agent keeps only "
                f"the last {KEPT_SECONDS:g} s; command on what the world shows now"
            )
        if seen:
            base = next((m.time for m in reversed(kept) if m.cycle <= seen), kept[0].time)
        return nearest(kept, base - ago)

    def since(self, time: float) -> list[PerceptRecord]:
        """Return the moments from a time on, s."""
        return [moment for moment in self._kept if moment.time >= time]

    def enter(
        self, due: PerceptRecord, as_entered: Callable[[PerceptRecord], PerceptRecord]
    ) -> None:
        """Have a state be active since a moment, as if its command had come in time.

        Args:
            due: the moment.
            as_entered: returns a later moment as it were with the state active.
        """
        kept = self._kept
        for place in range(len(kept) - 1, -1, -1):
            if kept[place].time <= due.time:
                break
            kept[place] = as_entered(kept[place])

    def reenter(self, left: str, state: str) -> None:
        """Have a state be active instead of the one that was entered last."""
        kept = self._kept
        for place in range(len(kept) - 1, -1, -1):
            if kept[place].state != left:
                break
            kept[place] = replace(kept[place], state=state)

    def window(self, due: PerceptRecord) -> tuple[PerceptRecord, ...]:
        """Return the percepts to keep with an example, for retiming the example later."""
        kept = self._kept
        start = min(due.time - WINDOW_SECONDS / 2, kept[-1].time - WINDOW_SECONDS) if kept else 0
        chosen = [moment for moment in kept if moment.time >= start]
        step = -(-len(chosen) // WINDOW_MAX) or 1
        return tuple(m for i, m in enumerate(reversed(chosen)) if i % step == 0)[::-1]


def nearest(moments: Sequence[PerceptRecord], time: float) -> PerceptRecord:
    """Return the one of some moments that is nearest to a time; the later one of two as near.

    One moment too early costs more than one too late: nothing may have happened yet.
    """
    after = bisect_left(moments, time, key=lambda moment: moment.time)
    around = moments[max(after - 1, 0) : after + 1]
    # Times are sums of steps that no number holds exactly.
    return min(reversed(around), key=lambda moment: round(abs(moment.time - time), 6))


def state_of(active: str) -> str:
    """Return the state that a command leaves: a flag state is left at once."""
    return START if active in FLAGS else active
