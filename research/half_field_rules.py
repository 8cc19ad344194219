"""The three roles written by hand, in the words that the lessons teach with; no examples.

`DEFAULT` is what `half_field.py search` found best on other episodes than those of the figures.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from hitab_core import START, Automaton, HandWritten, Term


@dataclass(frozen=True)
class Numbers:
    """The thresholds of the rules.

    Attributes:
        pressed: m from the closest opponent at which the ball is passed.
        shot: room that a shot needs, m.
        near: m from the goal within which the ball is passed in any case.
        lane: room that a pass needs, m.
        gone: m from the ball at which a supporter gives it up.
    """

    pressed: float = 4.0
    shot: float = -4.0
    near: float = 18.0
    lane: float = 0.0
    gone: float = 12.0


DEFAULT = Numbers()
STEPS = ("Dribble", "PassTo(best_mate)", "Shoot", "RunTo(spot)", "RunTo(near_wing)", "TurnToBall")
WORDS = (*STEPS, "PlayBall")


def _automaton(
    name: str, states: tuple[str, ...], features: tuple[str, ...], rule: Callable[..., str]
) -> Automaton:
    """Return an automaton with a rule of the state and all features."""

    def of(state: str) -> HandWritten:
        return HandWritten(partial(rule, state), tuple(range(len(features))))

    terms = tuple(map(Term.parse, states)), tuple(map(Term.parse, features))
    return Automaton(name, *terms, {state: of(state) for state in (START, *states)})


def rules(n: Numbers = DEFAULT, swapped: tuple[str, str] | None = None) -> dict[str, Automaton]:
    """Return the automata; each word of a swapped pair stands where the other did."""
    swap = {swapped[0]: swapped[1], swapped[1]: swapped[0]} if swapped else {}

    def word(state: str) -> str:
        return swap.get(state, state)

    def play(
        state: str, kickable: float, shot: float, goal: float, opponent: float, lane: float
    ) -> str:
        if kickable and shot > n.shot:
            return word("Shoot")
        if kickable and lane > n.lane and (opponent < n.pressed or goal < n.near):
            return word("PassTo(best_mate)")
        return word("Dribble")

    def lead(state: str, trails: float) -> str:
        return word("TurnToBall") if trails else word("PlayBall")

    playing = word("PlayBall"), word("Shoot")

    def support(place: str) -> Callable[..., str]:
        def rule(state: str, yelled: float, kickable: float, ball: float, shot: float) -> str:
            if kickable and shot > n.shot:
                return word("Shoot")
            plays = ball < n.gone if state in playing else yelled or kickable
            return word("PlayBall") if plays else word(place)

        return rule

    with_ball = (
        "BallIsKickable",
        "RoomOnWayTo(goal)",
        "DistanceTo(goal)",
        "DistanceTo(closest_taker)",
        "RoomOnWayTo(best_mate)",
    )
    without = "IWasYelledAt", "BallIsKickable", "DistanceTo(ball)", "RoomOnWayTo(goal)"
    made = [
        _automaton("PlayBall", STEPS, with_ball, play),
        _automaton("Playmaker", WORDS, ("ATeammateIsCloserToBall",), lead),
        _automaton("Striker", WORDS, without, support("RunTo(spot)")),
        _automaton("Winger", WORDS, without, support("RunTo(near_wing)")),
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
