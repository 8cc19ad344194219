"""What simulated people want their keepers to do: policies over what a keeper perceives.

An intention is a hierarchy of plans, as a person has it in mind before training: for each
automaton its states, its features and, in words of code, when to change from which state to which.
A plan's thresholds are its *edges*; a person's edges waver, see `simulated_people`. Played with
exact edges by hand-written transition functions, an intention plays itself; that is what the team
that a person trained is compared with.

``lessons`` is what the shipped lessons teach. The other intentions differ in their states, their
features, their edges, and in who goes to the ball.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from hitab_core import START, Automaton, HandWritten, Term

BALL, OFF = "DistanceTo(ball)", "DirectionTo(ball)"
TAKER, KICKABLE = "DistanceTo(closest_taker)", "BallIsKickable"
CLOSER, YELLED, DONE = "ATeammateIsCloserToBall", "IWasYelledAt", "Done"

DOUBT = (0.8, 1.0, 1.25)
"""People object only to what is wrong even for edges moved by these factors."""

Seen = Mapping[str, float]
Edges = Mapping[str, float]
Rule = Callable[[str, Seen, Edges], str]
"""``rule(state, seen, edges)`` returns the state to be in next."""


@dataclass(frozen=True)
class Plan:
    """One automaton as a person has it in mind.

    Attributes:
        name: of the automaton.
        states, features: that the person chooses before training.
        rule: what to do next.
        edges: the rule's thresholds, in the units of the features.
    """

    name: str
    states: tuple[str, ...]
    features: tuple[str, ...]
    rule: Rule
    edges: Edges

    def fitting(self, state: str, seen: Seen) -> set[str]:
        """Return the next states to which nobody with this plan would object."""
        return {
            self.rule(state, seen, {name: edge * factor for name, edge in self.edges.items()})
            for factor in DOUBT
        }

    def automaton(self) -> Automaton:
        """Return it as a hand-written automaton with exact edges."""

        def transition(state: str) -> HandWritten:
            def choose(*values: float) -> str:
                return self.rule(state, dict(zip(self.features, values, strict=True)), self.edges)

            return HandWritten(choose, tuple(range(len(self.features))))

        return Automaton(
            self.name,
            tuple(map(Term.parse, self.states)),
            tuple(map(Term.parse, self.features)),
            {state: transition(state) for state in (START, *self.states)},
        )


@dataclass(frozen=True)
class Intention:
    """What a person wants a team to do.

    Attributes:
        name: of the intention.
        description: in one sentence.
        plans: from the bottom up; all keepers perform the last one.
    """

    name: str
    description: str
    plans: tuple[Plan, ...]

    def automata(self) -> dict[str, Automaton]:
        """Return all plans as hand-written automata, by name."""
        return {plan.name: plan.automaton() for plan in self.plans}


PACES = ("Stop", "GoSlow", "GoMedium", "GoFast")
UP = 1.2
"""A faster pace begins this much farther out than the slower one did on the way in."""


def approach(state: str, seen: Seen, edges: Edges) -> str:
    """Go the slower the nearer the ball is; stop within reach.

    ``edges`` maps each pace but the fastest to the distance up to which it is right, in m.
    """
    at = PACES.index(state) if state in PACES else len(PACES)
    for pace, edge in edges.items():  # from the slowest
        if seen[BALL] <= edge * (UP if PACES.index(pace) >= at else 1.0):
            return pace
    return PACES[-1]


def go_to(state: str, seen: Seen, edges: Edges) -> str:
    """Turn to the ball until it is ahead, approach it until it is off."""
    off = abs(seen[OFF])
    if state == "ApproachBall":
        return "TurnToBall" if off > edges["off"] else state
    return "ApproachBall" if off < edges["ahead"] else "TurnToBall"


def control(state: str, seen: Seen, edges: Edges) -> str:
    """Go to the ball, wait until a taker is near, pass, and say so."""
    if state == "Pass":
        return "Done"
    if not seen[KICKABLE]:
        return "GotoBall"
    return "Pass" if state == "Stop" and seen[TAKER] < edges["near"] else "Stop"


def control_quietly(state: str, seen: Seen, edges: Edges) -> str:
    """Go to the ball, wait until a taker is near, and pass."""
    if state == "Pass":
        return "GotoBall"
    if not seen[KICKABLE]:
        return "GotoBall"
    return "Pass" if state == "Stop" and seen[TAKER] < edges["near"] else "Stop"


def yelled_at(state: str, seen: Seen, edges: Edges) -> str:
    """Take the ball when yelled at, get open after a pass; the closest one begins."""
    if state == START:
        return "GetOpen" if seen[CLOSER] else "ControlBall"
    if state == "GetOpen":
        return "ControlBall" if seen[YELLED] else state
    return "GetOpen" if seen[DONE] else state


def closest(state: str, seen: Seen, edges: Edges) -> str:
    """Take the ball if nobody is closer, else get open."""
    return "GetOpen" if seen[CLOSER] else "ControlBall"


def closest_until_done(state: str, seen: Seen, edges: Edges) -> str:
    """Take the ball if nobody is closer; get open after a pass, or if somebody is closer."""
    return "GetOpen" if seen[CLOSER] or (state == "ControlBall" and seen[DONE]) else "ControlBall"


def watchful(state: str, seen: Seen, edges: Edges) -> str:
    """Take the ball if nobody is closer; else face it if it is near, and get open if it is not."""
    if not seen[CLOSER]:
        return "ControlBall"
    if state == START or state == "ControlBall":
        return "GetOpen"
    if state == "GetOpen":
        return "TurnToBall" if seen[BALL] < edges["watch"] else state
    return "GetOpen" if seen[BALL] > edges["watch"] * UP else state


_APPROACH = Plan(
    "ApproachBall",
    ("GoFast", "GoMedium", "GoSlow", "Stop"),
    (BALL,),
    approach,
    {"Stop": 1.05, "GoSlow": 2.5, "GoMedium": 5.0},
)
_GO_TO = Plan(
    "GotoBall",
    ("TurnToBall", "ApproachBall"),
    (OFF,),
    go_to,
    {"off": math.radians(8.0), "ahead": math.radians(3.0)},
)
_CONTROL = Plan(
    "ControlBall",
    ("GotoBall", "Stop", "Pass", "Done"),
    (TAKER, KICKABLE),
    control,
    {"near": 2.5},
)
_TEAM = Plan("Keepaway", ("ControlBall", "GetOpen"), (CLOSER, YELLED, DONE), yelled_at, {})
_CLOSEST = replace(_TEAM, features=(CLOSER,), rule=closest)

_SPRINT = replace(
    _APPROACH, states=("GoFast", "GoSlow", "Stop"), edges={"Stop": 1.05, "GoSlow": 3.0}
)
_QUIETLY = replace(_CONTROL, states=("GotoBall", "Stop", "Pass"), rule=control_quietly)

_ALL = (
    Intention(
        "lessons",
        "what the shipped lessons teach",
        (_APPROACH, _GO_TO, _CONTROL, _TEAM),
    ),
    Intention(
        "closest",
        "who is closest plays the ball; nobody listens to yells, nobody says when he is done",
        (_APPROACH, _GO_TO, _QUIETLY, _CLOSEST),
    ),
    Intention(
        "sprinter",
        "runs, slows down once, turns late, and passes early",
        (
            _SPRINT,
            replace(_GO_TO, edges={"off": math.radians(17.0), "ahead": math.radians(6.0)}),
            replace(_CONTROL, edges={"near": 3.5}),
            _TEAM,
        ),
    ),
    Intention(
        "early",
        "passes when a taker is still 4 m away; who is closest plays the ball until the pass",
        (
            _APPROACH,
            _GO_TO,
            replace(_CONTROL, edges={"near": 4.0}),
            replace(_TEAM, features=(CLOSER, DONE), rule=closest_until_done),
        ),
    ),
    Intention(
        "watchful",
        "who is not closest faces the ball while it is near",
        (
            _APPROACH,
            _GO_TO,
            replace(_QUIETLY, edges={"near": 3.0}),
            Plan(
                "Keepaway",
                ("ControlBall", "GetOpen", "TurnToBall"),
                (CLOSER, BALL),
                watchful,
                {"watch": 6.0},
            ),
        ),
    ),
)

INTENTIONS: Mapping[str, Intention] = {intention.name: intention for intention in _ALL}
