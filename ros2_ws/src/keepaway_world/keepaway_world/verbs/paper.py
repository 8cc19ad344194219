"""The paper's figures, for comparison."""

from __future__ import annotations

from typing import NamedTuple


class Trained(NamedTuple):
    """A row of the paper's Table 1: the cost of training an automaton."""

    examples: int
    minutes: int


TABLE_1 = {
    "ApproachBall": Trained(18, 10),
    "GotoBall": Trained(10, 10),
    "ControlBall": Trained(11, 45),
    "Keepaway": Trained(10, 90),
}

HOLD_TIME_S = 14.6
HOLD_TIME_SE_S = 0.87
PASSES = 3.8
TAKER_SPEED = 0.25
