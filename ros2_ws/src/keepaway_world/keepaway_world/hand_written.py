"""A hard-coded automaton, to be used beside trained ones and to be compared with them.

As a team on the soccer field fields one trained behavior among programmed ones (the paper,
section 5), `ServoBall` is the programmed counterpart of a trained approach to the ball: put it
in the place of the trained automaton, or the other way round, and the rest need not know.
"""

from __future__ import annotations

import math

from hitab_core import START, Automaton, HandWritten, Use

FAR = 3.0  # m from which on it runs
NEAR = 1.7  # m up to which it slows down
OFF_FAR = math.radians(10.0)  # it turns if the ball is so far off its heading
OFF_NEAR = math.radians(25.0)  # likewise within NEAR, where a metre of kicking range forgives more


def servo(distance: float, direction: float, kickable: float) -> str:
    """Return what to do to reach a ball at its present position: a P-controller in steps.

    Args:
        distance: to the ball, m.
        direction: to the ball relative to the body, rad.
        kickable: 1 if the ball is within kicking range, else 0.
    """
    if kickable:
        return "Stop"
    if abs(direction) > (OFF_NEAR if distance < NEAR else OFF_FAR):
        return "TurnToBall"
    if distance > FAR:
        return "GoFast"
    return "GoMedium" if distance > NEAR else "GoSlow"


_STATES = ("TurnToBall", "GoFast", "GoMedium", "GoSlow", "Stop")
_SERVO = HandWritten(servo, (0, 1, 2))

SERVO_BALL = Automaton(
    "ServoBall",
    tuple(Use(state) for state in _STATES),
    (Use("DistanceTo", ("ball",)), Use("DirectionTo", ("ball",)), Use("BallIsKickable")),
    dict.fromkeys((START, *_STATES), _SERVO),
    description="go to where the ball is and stop within kicking range (hand-written)",
)
