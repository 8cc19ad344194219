"""A hard-coded automaton, for use with trained ones and for comparison.

A team can mix trained and programmed behaviors, like the one in the paper's section 5. `ServoBall`
is the programmed counterpart of a trained approach to the ball; each can replace the other without
changes elsewhere.
"""

from __future__ import annotations

import math

from hitab_core import START, Automaton, HandWritten, Term

RUN_DISTANCE = 3.0  # m: the keeper runs beyond this distance
SLOW_DISTANCE = 1.7  # m: the keeper slows down within this distance
OFF_FAR = math.radians(10.0)  # the keeper turns if the ball is farther off its heading
OFF_NEAR = math.radians(25.0)  # the same within SLOW_DISTANCE, where less precision is needed


def servo(distance: float, direction: float, kickable: float) -> str:
    """Return the behavior to reach the ball at its current position: a stepped P-controller.

    Args:
        distance: to the ball, m.
        direction: to the ball relative to the body, rad.
        kickable: 1 if the ball is within kicking range, else 0.
    """
    if kickable:
        return "Stop"
    if abs(direction) > (OFF_NEAR if distance < SLOW_DISTANCE else OFF_FAR):
        return "TurnToBall"
    if distance > RUN_DISTANCE:
        return "GoFast"
    return "GoMedium" if distance > SLOW_DISTANCE else "GoSlow"


_STATES = ("TurnToBall", "GoFast", "GoMedium", "GoSlow", "Stop")
_SERVO = HandWritten(servo, (0, 1, 2))

SERVO_BALL = Automaton(
    "ServoBall",
    tuple(Term(state) for state in _STATES),
    (Term("DistanceTo", ("ball",)), Term("DirectionTo", ("ball",)), Term("BallIsKickable")),
    dict.fromkeys((START, *_STATES), _SERVO),
    description="go to where the ball is and stop within kicking range (hand-written)",
)
