"""What a person let pass: times in which a state went on and nobody commanded.

Somebody who watches and does not object agrees, as far as there was time to object: a second of
silence says little of a person who needs a second to react. What a late command was meant for was
not so in silent times, or the person would have commanded (`hitab_core.training.lateness`).
Nobody can tell who is watching, so only what was silent shortly before a command counts: the
person was there then. Commands that were not late stay where they are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from hitab_core.automaton import START
from hitab_core.training.moments import Moment

PRESENT_SECONDS = 30.0
"""Who commands has been watching for so long, in the person's seconds."""

MOMENTS = 12
"""The most moments that are kept of a silent time."""

OPEN_MAX = 100 * MOMENTS
"""The most that are kept while it goes on: a robot may stand in one state for hours."""

AT_ONCE = 5
"""The most silent times that one command confirms, the latest ones."""

KEPT = 40
"""The most silent times that are kept, the latest ones."""


@dataclass(frozen=True)
class Stretch:
    """A time in which a state went on and nobody commanded.

    Attributes:
        end: when the state ended by itself, or the episode did, s.
        pace: simulated seconds in a second of the person.
        moments: of this time, in one state, ascending.
    """

    end: float
    pace: float
    moments: tuple[Moment, ...]

    @property
    def state(self) -> str:
        """The state that went on."""
        return self.moments[0].state

    @property
    def waits(self) -> list[float]:
        """How long the person let each moment pass, in the person's seconds."""
        return [(self.end - moment.time) / self.pace for moment in self.moments]

    def to_record(self) -> dict[str, Any]:
        """Return it as plain data for the journal."""
        moments = [moment.to_record() for moment in self.moments]
        return {"end": self.end, "pace": self.pace, "moments": moments}

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Stretch:
        """Read what `to_record` wrote."""
        moments = tuple(map(Moment.from_record, record["moments"]))
        return cls(float(record["end"]), float(record["pace"]), moments)


class Silence:
    """The silent times of a training.

    Attributes:
        kept: the latest ones of which it is known that the person was there.
    """

    def __init__(self) -> None:
        self.kept: list[Stretch] = []
        self._ended: list[tuple[float, list[Moment]]] = []
        self._open: list[Moment] = []

    def see(self, moment: Moment) -> None:
        """Go on, in what was perceived now."""
        if self._open and moment.state != self._open[-1].state:
            self.end(moment.time)
        if moment.state != START:  # where an agent waits to be told what to do
            self._open.append(moment)
            if len(self._open) > OPEN_MAX:
                del self._open[1::2]

    def end(self, time: float | None = None) -> None:
        """End the present silent time: the state, or the episode, was over."""
        if self._open:
            end = self._open[-1].time if time is None else time
            step = -(-len(self._open) // MOMENTS)
            self._ended.append((end, self._open[::step]))
            del self._ended[:-AT_ONCE]
            self._open = []

    def broken(self, time: float, pace: float) -> list[Stretch]:
        """End it by a command; return the silent times in which the person was there.

        Args:
            time: of the command, s.
            pace: simulated seconds in a second of the person; 0: the situation has waited.
        """
        self._open = []
        if not pace:
            return []
        ended, self._ended = self._ended, []
        there = time - PRESENT_SECONDS * pace
        return [Stretch(end, pace, tuple(moments)) for end, moments in ended if end >= there]

    def keep(self, silent: Sequence[Stretch]) -> None:
        """Keep silent times in which the person was there."""
        self.kept += silent
        del self.kept[:-KEPT]
