"""What a person let pass: times in which a state went on and nobody commanded.

Somebody who watches and does not object agrees, as far as there was time to object: a second of
silence says little of a person who needs a second to react (`hitab_core.training.lateness`).
Nobody can tell who is watching, so only what was silent shortly before a command counts: the
person was there then. It is used twice:

- What a command was meant for was not so in silent times, or the person would have commanded.
- Where what was learned would leave a state though the person let it go on, a default example says
  to stay, unless a command is nearer. It ends where something else was demonstrated, like those of
  entering a state, so it moves no boundary between commands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from hitab_core.advice.evidence import Evidence
from hitab_core.advice.nearness import apart
from hitab_core.automaton import START, Automaton
from hitab_core.domain import Scale
from hitab_core.example import Example, ExampleKind
from hitab_core.spread import spreads
from hitab_core.training.moments import Moment

PRESENT_SECONDS = 30.0
"""Who commands has been watching for so long, in the person's seconds."""

MOMENTS = 12
"""The most moments that are kept of a silent time."""

AT_ONCE = 5
"""The most silent times that one command confirms, the latest ones."""

KEPT = 40
"""The most silent times that are kept, the latest ones."""

SURE = 0.9
"""A person would have objected by now with this probability."""

LEARNED_MAX = 3
"""The most default examples that come with one command; the next one may bring others."""


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


def let_pass(
    silent: Sequence[Stretch],
    learn: Callable[[Sequence[Example]], Automaton],
    scales: Sequence[Scale],
    values: Callable[[Moment], tuple[float, ...]],
    patience: Callable[[float], float],
    number: int,
    command: int,
) -> list[Example]:
    """Return default examples of silent moments in which what was learned would leave the state.

    Args:
        silent: times.
        learn: returns what is learned from the examples there are, and from some more.
        scales: of the features.
        values: returns the features' values in a moment.
        patience: returns how probable it is that the person needs longer than some seconds.
        number, command: of the first example, and of all of them.
    """
    found: list[Example] = []
    while len(found) < LEARNED_MAX:
        automaton = learn(found)
        names = list(map(str, automaton.features))
        for stretch, moment in _certain(silent, patience):
            function, there = automaton.transitions.get(stretch.state), values(moment)
            if function is None or np.isnan(there).any():
                continue
            if function.explain(there, names).distribution.get(stretch.state, 0.0) > 0.0:
                continue
            evidence = Evidence.of(stretch.state, automaton.examples, scales, names)
            if _commanded_nearby(evidence, there):
                continue
            kind, next_number = ExampleKind.DEFAULT, number + len(found)
            of_moment = (kind, next_number, command, moment.cycle, 0.0, moment.readings)
            found.append(Example(stretch.state, there, stretch.state, *of_moment))
            break
        else:
            break
    return found


def _certain(
    silent: Sequence[Stretch], patience: Callable[[float], float]
) -> Iterator[tuple[Stretch, Moment]]:
    """Yield the moments to which the person would have objected, the latest times first."""
    for stretch in reversed(silent):
        for moment, waited in zip(stretch.moments, stretch.waits, strict=True):
            if patience(waited) > 1.0 - SURE:
                break
            yield stretch, moment


def _commanded_nearby(evidence: Evidence, there: Sequence[float]) -> bool:
    """Return whether a command is nearer to a situation than what says to stay."""
    spread = spreads(evidence.values, evidence.scales)
    away = apart(np.array([evidence.placed(there)]), evidence.values, evidence.scales, spread)[0]
    assumed = evidence.default
    return bool(away[~assumed].min(initial=np.inf) < away[assumed].min(initial=np.inf))
