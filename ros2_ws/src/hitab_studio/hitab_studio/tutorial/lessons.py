"""The commands that the tutorial teaches, and the situations for them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from hitab_client import Training
from hitab_core import FLAGS

FEATURES = (KICKABLE, DIRECTION) = ("BallIsKickable", "DirectionTo(ball)")


@dataclass(frozen=True)
class Situation:
    """A command, and the situation in which the person should give it.

    Attributes:
        behavior: the behavior to command.
        where: place of the ball, in words.
        bearing: direction from the agent to the ball, relative to its heading and
            counterclockwise, degrees.
        distance: distance from the agent to the ball, m.
        tolerance: difference from the bearing within which the situation counts, degrees.
    """

    behavior: str
    where: str
    bearing: float
    distance: float = 4.0
    tolerance: float = 30.0

    def fits(self, percept: Mapping[str, float]) -> bool:
        """Whether a percept, with the values of `FEATURES`, is this situation."""
        near = bool(percept.get(KICKABLE, math.nan) > 0.5)
        off = percept.get(DIRECTION, math.nan) - math.radians(self.bearing)
        turned = abs(math.remainder(off, math.tau)) <= math.radians(self.tolerance)
        return near == (self.distance < 1.0) and turned


LESSONS = (
    Situation("TurnToBall", "behind it", 150.0, tolerance=45.0),
    Situation("GoFast", "ahead of it, a little to its left", 10.0, tolerance=8.0),
    Situation("TurnToBall", "farther to its left", 45.0, tolerance=20.0),
    Situation("GoFast", "ahead of it, a little to its right", -10.0, tolerance=8.0),
    Situation("TurnToBall", "farther to its right", -45.0, tolerance=20.0),
    Situation("GoFast", "ahead of it again", 0.0, tolerance=18.0),
    Situation("Stop", "right at its nose", 0.0, 0.8, tolerance=60.0),
    Situation("TurnToBall", "behind it again", 180.0, tolerance=60.0),
)


def taught(training: Training, lessons: Sequence[Situation] = LESSONS) -> tuple[int, bool]:
    """Return how many lessons a training has had, and whether its last command was another one.

    After the last lesson, no command is wrong.
    """
    names = list(map(str, training.features))
    count, is_wrong = 0, False
    for example in training.examples:
        if example.is_default or example.next_state in FLAGS or count == len(lessons):
            continue
        percept = dict(zip(names, example.features, strict=True))
        lesson = lessons[count]
        is_wrong = example.next_state != lesson.behavior or not lesson.fits(percept)
        count += not is_wrong
    return count, is_wrong
