"""How a simulated person acts, and what it notes of what it did."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Habits:
    """How a person acts; times are in s.

    Attributes:
        reaction: the shortest and longest time from seeing to commanding.
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


@dataclass
class Diary:
    """What a person did.

    Attributes:
        counts: commands, wrong ones, late ones, those not given, undos, corrections, trials.
        content: the plans with which the person was content.
        seconds: simulated time that the world ran.
        failure: why the training could not be finished; "" if it was.
    """

    counts: Counter[str] = field(default_factory=Counter)
    content: list[str] = field(default_factory=list)
    seconds: float = 0.0
    failure: str = ""

    def figures(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {
            "counts": dict(self.counts),
            "content": list(self.content),
            "seconds": round(self.seconds, 1),
            "failure": self.failure,
        }
