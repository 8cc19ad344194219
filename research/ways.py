"""Ways in which people press keys and use time: the rows that a table of simulated people has.

Fixed before the engine was made for them: who goes back misses the right frame by 0.1 s (the
standard deviation) and needs 4 s; a key that freezes the world comes after the simple reaction
time of 0.3 s. Nobody freezes or goes back by default; `STUDIO` is what the studio offers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from random import Random

from habits import MEASURED, Habits
from intentions import Seen

SPREAD = 0.28
"""Of the logarithm of the delays of people who are late by about a given time: a novice's."""

SIMPLE = 0.3
"""The time until a key is pressed that only freezes the world, s."""

MISSES = 0.1
"""By how much a person misses the right frame who goes back: the standard deviation, s."""

GOING_BACK = 4.0
"""What going back for a command costs the person, s."""


@dataclass(frozen=True)
class Ways:
    """How a person presses keys and uses time.

    Attributes:
        delay: by how much the person is late, s: 0: presses in the cycle where it is due;
            negative: anticipates; None: as the person's habits are.
        pace: of the world while the person is in control, as a part of its usual pace.
        answers: questions that the person answers between trials.
        surprised: whether the person sees thresholds coming, and is in time for these, but reacts
            to what is so or not so, and to wrong changes of state, as the habits say.
        freezes: share of the commands at which the person freezes the world first.
        goes_back: share of the commands that the person gives again for the right frame.
    """

    delay: float | None = None
    pace: float = 1.0
    answers: int = 1
    surprised: bool = False
    freezes: float = 0.0
    goes_back: float = 0.0

    def habits(self, usual: Habits) -> Habits:
        """Return the habits of a person who is late by this delay."""
        if self.delay is None:
            return usual
        choice = (self.delay, SPREAD) if self.delay > 0.0 else None
        return replace(usual, reaction=(0.0, 0.0), choice=choice)

    @property
    def foresees(self) -> float:
        """How far ahead the person looks, s."""
        return max(0.0, -(self.delay or 0.0))


AS_THEY_ARE = Ways()
STUDIO = Ways(pace=0.5, answers=3, goes_back=0.3)
"""The studio's defaults."""


class Timing:
    """Draws when a person presses; apart from other draws, so that people stay who they are.

    Args:
        ways, habits: of the person.
        seed: of these draws.
    """

    def __init__(self, ways: Ways, habits: Habits, seed: int) -> None:
        self.ways, self._habits = ways, habits
        self._random = Random(f"ways {seed}")

    def reacts(self, random: Random, *, surprise: bool) -> tuple[float, bool]:
        """Return the time until a command is given, s, and whether the world is frozen then."""
        seconds = self._habits.reacts(random)
        if self.ways.surprised and not surprise:
            seconds = 0.0
        if self.ways.freezes and self._random.random() < self.ways.freezes:
            return min(SIMPLE, seconds), True
        return seconds, False

    def again(self) -> float | None:
        """Return how far from the right frame a command is given again, s; None if it is not."""
        if self.ways.goes_back and self._random.random() < self.ways.goes_back:
            return self._random.gauss(0.0, MISSES)
        return None

    def foreseen(self, before: Seen, seen: Seen, seconds: float) -> Mapping[str, float]:
        """Return what somebody sees who extrapolates the change of a cycle of so many seconds."""
        ahead = self.ways.foresees / seconds
        changes = {f: ahead * (seen[f] - before[f]) for f in MEASURED if f in seen}
        return {f: value + changes.get(f, 0.0) for f, value in seen.items()}
