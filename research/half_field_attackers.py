"""Attackers without any example, in the words of ``half_field``: rule-based and random ones.

They were written before there was any lesson for attackers, and have not been changed since.
"""

from __future__ import annotations

from random import Random
from typing import Any

from half_field_world.body import AttackerBody
from half_field_world.domain import DOMAIN
from hitab_core import START, Automaton, HandWritten, Term, agent_seed

FEATURES = (
    "BallIsKickable",
    "ATeammateIsCloserToBall",
    "RoomOnWayTo(goal)",
    "RoomOnWayTo(best_mate)",
    "DistanceTo(closest_taker)",
    "DistanceTo(goal)",
    "DistanceTo(spot)",
    "DistanceTo(far_wing)",
)
STATES = ("MeetBall", "Dribble", "Shoot", "PassTo(best_mate)", "RunTo(spot)", "RunTo(far_wing)")


def attack(
    kickable: float,
    closer: float,
    shot: float,
    lane: float,
    opponent: float,
    goal: float,
    spot: float,
    wing: float,
) -> str:
    """Return what an attacker does; all play by the same rules."""
    if kickable:
        if shot > 0.0 and goal < 25.0:
            return "Shoot"
        if opponent < 4.0 and lane > 0.0:
            return "PassTo(best_mate)"
        return "Dribble"
    if not closer:
        return "MeetBall"
    return "RunTo(spot)" if spot < wing else "RunTo(far_wing)"


RULE_BASED = Automaton(
    "RuleBased",
    tuple(map(Term.parse, STATES)),
    tuple(map(Term.parse, FEATURES)),
    dict.fromkeys((START, *STATES), HandWritten(attack, tuple(range(len(FEATURES))))),
)


class RandomAttacker:
    """Draws one of the six behaviors every half second."""

    EVERY = 5

    def __init__(self, name: str) -> None:
        self.body: Any = AttackerBody(name)
        self._random = Random()

    def begin(self, seed: int, episode: int) -> None:
        """Begin an episode."""
        self._random.seed(agent_seed(seed, episode, self.body.name))
        self._cycle = 0

    def tick(self) -> None:
        """Act."""
        if self._cycle % self.EVERY == 0:
            self._use = Term.parse(self._random.choice(STATES))
        self._cycle += 1
        targets = [DOMAIN.targets[name].resolve(self.body) for name in self._use.arguments]
        DOMAIN.behaviors[self._use.name].pulse(self.body, *targets)
