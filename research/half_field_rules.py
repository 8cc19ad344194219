"""The three roles written by hand, in the words that the lessons teach with; no examples.

`DEFAULT` is what `half_field.py search` found best on other episodes than those of the figures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hitab_core import START, Automaton, HandWritten, Use


@dataclass(frozen=True)
class Numbers:
    """The thresholds of the rules.

    Attributes:
        pressed: m from the closest opponent at which the ball is passed.
        shot: room that a shot needs, m; early: of the striker's.
        near: m from the goal within which the ball is passed in any case.
        lane: room that a pass needs, m.
    """

    pressed: float = 6.0
    shot: float = 0.0
    early: float = 0.0
    near: float = 18.0
    lane: float = 0.0


DEFAULT = Numbers()


def _automaton(
    name: str, states: tuple[str, ...], features: tuple[str, ...], rule: Callable[..., str]
) -> Automaton:
    function = HandWritten(rule, tuple(range(len(features))))
    uses = tuple(map(Use.parse, states)), tuple(map(Use.parse, features))
    return Automaton(name, *uses, dict.fromkeys((START, *states), function))


def rules(n: Numbers = DEFAULT, swapped: tuple[str, str] | None = None) -> dict[str, Automaton]:
    """Return the automata; each word of a swapped pair stands where the other did."""
    swap = {swapped[0]: swapped[1], swapped[1]: swapped[0]} if swapped else {}

    def word(state: str) -> str:
        return swap.get(state, state)

    def play(kickable: float, shot: float, goal: float, opponent: float, lane: float) -> str:
        if kickable and shot > n.shot:
            return word("Shoot")
        if kickable and lane > n.lane and (opponent < n.pressed or goal < n.near):
            return word("PassTo(best_mate)")
        return word("Dribble")

    def lead(trails: float) -> str:
        return word("TurnToBall") if trails else word("PlayBall")

    def support(place: str) -> Callable[..., str]:
        def rule(yelled: float, kickable: float, ball: float, shot: float) -> str:
            if kickable and shot > n.early:
                return word("Shoot")
            return word("PlayBall") if yelled or kickable or ball < 3.0 else word(place)

        return rule

    spots = "RunTo(spot)", "RunTo(near_wing)"
    with_ball = (
        "BallIsKickable",
        "RoomOnWayTo(goal)",
        "DistanceTo(goal)",
        "DistanceTo(closest_taker)",
        "RoomOnWayTo(best_mate)",
    )
    without = "IWasYelledAt", "BallIsKickable", "DistanceTo(ball)", "RoomOnWayTo(goal)"
    other = ("PlayBall", "Shoot", "TurnToBall")
    made = [
        _automaton("PlayBall", ("Dribble", "PassTo(best_mate)", "Shoot"), with_ball, play),
        _automaton("Playmaker", other, ("ATeammateIsCloserToBall",), lead),
        _automaton("Striker", (*spots, *other), without, support("RunTo(spot)")),
        _automaton("Winger", (*spots, *other), without, support("RunTo(near_wing)")),
    ]
    return {automaton.name: automaton for automaton in made}


SWAPS = (
    ("Dribble", "PassTo(best_mate)"),
    ("Dribble", "Shoot"),
    ("PassTo(best_mate)", "Shoot"),
    ("RunTo(spot)", "RunTo(near_wing)"),
    ("PlayBall", "TurnToBall"),
)
"""Pairs of words that `half_field.py compare` swaps, to tell what the words alone are worth."""
