"""The domain ``keepaway_handcoded``: keepers whose whole behavior is hard-coded automata.

`Keepaway` is made of `ControlBall`, which is made of `GotoBall`. Each can be trained instead, as
by the paper's team at RoboCup 2011: the team trained the servoing and approaching of the ball,
here `GotoBall`, on the field, and played with it beside its other hard-coded behaviors.

The automata use only the words of the domain ``keepaway``, so that each can be trained.
"""

from __future__ import annotations

import math

from hitab_core import START, Automaton, Domain, HandWritten, Term
from keepaway_world.domain import DOMAIN as KEEPAWAY_WORDS

OFF = math.radians(9.0)  # the keeper turns if the ball is farther off its heading
WALK_DISTANCE = 4.5  # m: within this distance the keeper goes slowly, not to overshoot
PRESSED = 2.5  # m: the keeper passes if a taker is this close


def goto_ball(distance: float, direction: float) -> str:
    """Return the behavior that reaches the ball at its current position.

    Args:
        distance: to the ball, m.
        direction: to the ball relative to the body, rad.
    """
    if abs(direction) > OFF:
        return "TurnToBall"
    return "GoSlow" if distance <= WALK_DISTANCE else "GoFast"


def control_ball(taker: float, kickable: float) -> str:
    """Return the behavior at the ball: reach it, hold it, and pass when pressed.

    Args:
        taker: distance to the closest taker, m.
        kickable: 1 if the ball is within kicking range, else 0.
    """
    if not kickable:
        return "GotoBall"
    return "Pass" if taker <= PRESSED else "Stop"


def begin_keepaway(closer: float) -> str:
    """Return the first behavior: the closest keeper takes the ball.

    Args:
        closer: 1 if a teammate is closer to the ball, else 0.
    """
    return "GetOpen" if closer else "ControlBall"


def await_pass(yelled: float) -> str:
    """Return the behavior while open: take the ball if a passer has yelled to this keeper.

    Args:
        yelled: 1 if so, else 0.
    """
    return "ControlBall" if yelled else "GetOpen"


def after_pass(done: float) -> str:
    """Return the behavior while in control: get open once the ball has been passed.

    Args:
        done: 1 if `ControlBall` has raised Done, else 0.
    """
    return "GetOpen" if done else "ControlBall"


_GOING = ("TurnToBall", "GoFast", "GoSlow")
_IN_CONTROL = ("GotoBall", "Stop")

GOTO_BALL = Automaton(
    "GotoBall",
    tuple(Term(state) for state in _GOING),
    (Term("DistanceTo", ("ball",)), Term("DirectionTo", ("ball",))),
    dict.fromkeys((START, *_GOING), HandWritten(goto_ball, (0, 1))),
    description="servo on the ball and approach it (hand-written)",
)

CONTROL_BALL = Automaton(
    "ControlBall",
    tuple(Term(state) for state in (*_IN_CONTROL, "Pass", "Done")),
    (Term("DistanceTo", ("closest_taker",)), Term("BallIsKickable")),
    {
        **dict.fromkeys((START, *_IN_CONTROL), HandWritten(control_ball, (0, 1))),
        "Pass": HandWritten(lambda: "Done"),
    },
    description="go to the ball, wait until a taker is near, pass it; raises Done (hand-written)",
)

KEEPAWAY_AUTOMATON = Automaton(
    "Keepaway",
    (Term("GetOpen"), Term("ControlBall")),
    (Term("ATeammateIsCloserToBall"), Term("IWasYelledAt"), Term("Done")),
    {
        START: HandWritten(begin_keepaway, (0,)),
        "GetOpen": HandWritten(await_pass, (1,)),
        "ControlBall": HandWritten(after_pass, (2,)),
    },
    description="keep the ball, together with two others who do the same (hand-written)",
)

DOMAIN = Domain.of(
    "keepaway_handcoded",
    "1",
    KEEPAWAY_WORDS.body,
    behaviors=KEEPAWAY_WORDS.behaviors.values(),
    features=KEEPAWAY_WORDS.features.values(),
    targets=KEEPAWAY_WORDS.targets.values(),
    automata=(GOTO_BALL, CONTROL_BALL, KEEPAWAY_AUTOMATON),
)
