"""How a simulated person acts, and what it notes of what it did."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import log
from random import Random
from typing import Any

from intentions import BALL, KICKABLE, OFF, TAKER, Seen

from keepaway_world.parameters import PAPER

MEASURED = (BALL, OFF, TAKER)
"""What people see only roughly."""


@dataclass(frozen=True)
class Habits:
    """How a person acts; times are in s.

    Attributes:
        reaction: the shortest and longest time from seeing to commanding.
        choice: the median and the spread (of the logarithm) of what choosing among keys adds to
            it, log-normally; None: nothing.
        sight: the standard deviation of how far off, relative to itself, a distance or an angle
            is seen; it is the same during a decision.
        waver: each decision moves the intention's edges by up to this fraction.
        inattention: fraction of the decisions at which the person looks away: in half of them the
            command comes late, in the other half it is not given.
        away: the shortest and longest time of looking away.
        wrong: fraction of the commands that are another one than meant.
        repairs: fraction of the slips that the person noticed (wrong or late) and takes back by
            undoing or deleting; of the others, wrong commands are followed by the right one.
        notices: the shortest and longest time until the person notices a slip.
        patience: how long the keeper may do what was not intended before the person reacts.
        overlooks: fraction of the commands that the person does not look at again.
        content: clean trials in a row after which the person is content.
        trials: the most trials of one plan.
    """

    reaction: tuple[float, float] = (0.2, 0.4)
    choice: tuple[float, float] | None = None
    sight: float = 0.0
    waver: float = 0.15
    inattention: float = 0.1
    away: tuple[float, float] = (1.0, 3.0)
    wrong: float = 0.0
    repairs: float = 0.5
    notices: tuple[float, float] = (0.3, 0.8)
    patience: float = 0.3
    overlooks: float = 0.1
    content: int = 3
    trials: int = 14

    def reacts(self, random: Random) -> float:
        """Draw a time from seeing to commanding."""
        seconds = random.uniform(*self.reaction)
        if self.choice is not None:
            median, spread = self.choice
            seconds += random.lognormvariate(log(median), spread)
        return seconds

    def errors(self, random: Random) -> Mapping[str, float]:
        """Draw by which factors what is measured is seen wrongly during a decision."""
        return {f: 1.0 + random.gauss(0.0, self.sight) for f in MEASURED if self.sight}


def looked_at(seen: Seen, errors: Mapping[str, float]) -> Seen:
    """Return what is seen with some errors; whether the ball is within reach follows from them."""
    if not errors:
        return seen
    found = {f: value * errors.get(f, 1.0) for f, value in seen.items()}
    if BALL in found and KICKABLE in found:
        found[KICKABLE] = float(found[BALL] <= PAPER.kickable)
    return found


@dataclass
class Diary:
    """What a person did.

    Attributes:
        counts: commands, wrong ones, late ones, those not given, undos, corrections, trials.
        content: the plans with which the person was content.
        seconds: simulated time that the world ran.
        own_seconds: the person's own time while the world ran, or while going back.
        off: for each command whose moment is known, how much later it is recorded than it was due,
            s of simulated time, and whether in another state than meant.
        failure: why the training could not be finished; "" if it was.
    """

    counts: Counter[str] = field(default_factory=Counter)
    content: list[str] = field(default_factory=list)
    seconds: float = 0.0
    own_seconds: float = 0.0
    off: list[tuple[float, bool]] = field(default_factory=list)
    failure: str = ""

    def figures(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "counts": dict(self.counts),
            "content": list(self.content),
            "seconds": round(self.seconds, 1),
            "own_seconds": round(self.own_seconds, 1),
            "off": [(round(seconds, 2), other) for seconds, other in self.off],
            "failure": self.failure,
        }
