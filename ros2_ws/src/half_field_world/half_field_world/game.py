"""Half-field attack: how an episode begins, and when it ends.

The lines, the goal, the goalie's catch and offside are those of rcssserver 19. An episode ends as
in Half Field Offense, at the first of these: a goal, the ball out of the half, caught, or held by
a defender, and the time limit. Posts do not reflect the ball.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from random import Random
from typing import Any

from half_field_world import field
from half_field_world.defence import Defence
from half_field_world.parameters import HalfFieldParameters
from hitab_world import Entity, Look, Measure
from hitab_world.simulating.snapshots import whole
from keepaway_world.game.physics import Mover, Names, Physics
from keepaway_world.game.referee import OUT, Referee
from keepaway_world.game.rules import BALL_LOOK, TAKER, Rules
from keepaway_world.world import KeepawayWorld

GOAL, CAUGHT, OFFSIDE, TIME = "goal", "caught", "offside", "time"
OFFSIDE_AREA = 2.5  # m: a player in an offside position takes part in play this near the ball

STOPS = (
    ("goal_l", GOAL),
    ("goalie_catch_ball_r", CAUGHT),
    ("free_kick_r", CAUGHT),  # is said next; after a foul, another word is said first
    ("offside_l", OFFSIDE),
    *((word, OUT) for word in ("kick_in", "corner_kick", "goal_kick")),
)
"""Reasons for the end of an episode when an rcssserver stops play, by the server's play mode."""

BALL_FROM_MIDLINE, BALL_ASIDE = (5.0, 15.0), 15.0
BEHIND_BALL = 2.0
MATES_AHEAD, MATES_ASIDE = (0.0, 6.0), (8.0, 14.0)
DEFENDERS_FROM_GOAL, DEFENDERS_ASIDE = (13.0, 21.0), 10.0
GOALIE_FROM_GOAL = 1.5

POST_LOOK = Look("#555555", "square", faces=False, labelled=False)
POSTS = tuple(
    Entity(f"post_{i + 1}", "post", field.GOAL_X, side * field.GOAL_WIDTH / 2.0, radius=0.25)
    for i, side in enumerate((-1.0, 1.0))
)

DEFAULT = HalfFieldParameters()


class HalfFieldReferee(Referee):
    """The referee of one episode at a time."""

    def __init__(self, physics: Physics) -> None:
        p = physics.parameters
        assert isinstance(p, HalfFieldParameters)
        self._physics = physics
        self._offside_counts, self._time_limit = p.offside, p.time_limit
        super().__init__(p)

    def begin(self) -> None:
        """Forget the last episode."""
        super().begin()
        self._cycles = 0
        self._caught = False
        self._offside: list[str] = []

    def saw_kick(self, player: Mover) -> None:
        """Record that a player kicked the ball, and which players are in an offside position."""
        super().saw_kick(player)
        if not self._offside_counts:
            return
        if player.name in self._offside:  # plays the ball, which is judged after this cycle
            return
        physics = self._physics
        last = sorted((taker.x for taker in physics.takers), reverse=True)
        line = max(physics.ball.x, *last[1:2], -field.GOAL_X)
        mates = physics.keepers if player in physics.keepers else ()
        self._offside = [m.name for m in mates if m is not player and m.x > line]

    def saw_catch(self, player: Mover) -> None:
        """Record that the goalie tries to catch the ball."""
        ball = self._physics.ball
        near = math.hypot(player.x - ball.x, player.y - ball.y) <= field.CATCHABLE
        if near and field.in_area(ball.x, ball.y) and player is self._physics.takers[-1]:
            self._caught = True

    def judge(self, physics: Physics) -> str | None:
        """Check the state after a cycle; return why the episode ends, or None."""
        self._cycles += 1
        if self._caught:
            return CAUGHT
        ball = physics.ball
        for keeper in physics.keepers:
            away = math.hypot(keeper.x - ball.x, keeper.y - ball.y)
            if keeper.name in self._offside and away < OFFSIDE_AREA:
                return OFFSIDE
        ended = super().judge(physics)
        if ended is None and self._cycles >= self._time_limit:
            return TIME
        return ended

    def crossed(self, ball: Mover) -> str:
        """Return `GOAL` or `OUT` if the whole ball is behind a line, else ""."""
        beyond = ball.x - field.GOAL_X - ball.radius
        if beyond > 0.0:
            at_line = ball.y - (beyond * ball.vy / ball.vx if ball.vx > 0.0 else 0.0)
            return GOAL if abs(at_line) <= field.GOAL_WIDTH / 2.0 + field.POST_RADIUS else OUT
        out = ball.x < -field.GOAL_X - ball.radius or abs(ball.y) > field.WIDTH / 2.0 + ball.radius
        return OUT if out else ""

    def measures(self, ended: str) -> dict[str, float]:
        """Return the measures of the episode so far."""
        return {**super().measures(ended), "goals": float(ended == GOAL)}

    def state(self) -> dict[str, Any]:
        """Return the referee's counts as JSON-serializable data."""
        return {**super().state(), "cycles": self._cycles, "offside": list(self._offside)}

    def restore(self, state: Mapping[str, Any], players: Sequence[Mover]) -> None:
        """Restore what `state` returned.

        Raises:
            KeyError, TypeError, ValueError: if it is not such a state; nothing has changed.
        """
        cycles = whole(state["cycles"])
        names = {player.name: player.name for player in players}
        offside = [names[name] for name in state["offside"]]
        super().restore(state, players)
        self._cycles, self._offside, self._caught = cycles, offside, False


def set_up(physics: Physics, random: Random) -> None:
    """Put everything in its initial position, at rest, facing anywhere.

    Any attacker stands just behind the ball, and the others beside the ball, one on each
    side. The defenders stand before their penalty area, the goalie before its goal.
    """
    midline, uniform = -field.GOAL_X, random.uniform
    x, y = midline + uniform(*BALL_FROM_MIDLINE), uniform(-BALL_ASIDE, BALL_ASIDE)
    physics.put(physics.ball, x, y)
    first = random.randrange(len(physics.keepers))
    for number, attacker in enumerate(physics.keepers):
        place = (first + number) % len(physics.keepers)
        if place == 0:
            at = x - BEHIND_BALL, y
        else:
            side = 1.0 if place % 2 else -1.0
            at = x + uniform(*MATES_AHEAD), y + side * uniform(*MATES_ASIDE)
        physics.put(attacker, *at, uniform(-math.pi, math.pi))
    *defenders, goalie = physics.takers
    for defender in defenders:
        at = (
            field.GOAL_X - uniform(*DEFENDERS_FROM_GOAL),
            uniform(-DEFENDERS_ASIDE, DEFENDERS_ASIDE),
        )
        physics.put(defender, *at, uniform(-math.pi, math.pi))
    physics.put(goalie, field.GOAL_X - GOALIE_FROM_GOAL, 0.0, uniform(-math.pi, math.pi))


def names_of(p: HalfFieldParameters) -> Names:
    """Return the names of attackers and defenders; the last of these is the goalie."""
    return (
        [f"attacker_{i + 1}" for i in range(p.keepers)],
        [*(f"defender_{i + 1}" for i in range(p.takers - 1)), "goalie"],
    )


def rules_of(p: HalfFieldParameters) -> Rules:
    """Return the rules of the game."""
    return Rules(
        "half_field",
        {
            "attacker": Look(),
            "defender": TAKER,
            "goalie": Look("#8e5bb5"),
            "ball": BALL_LOOK,
            "post": POST_LOOK,
        },
        (Measure("goals"), Measure("passes"), Measure("seconds", "s", "less")),
        HalfFieldReferee,
        Defence,
        set_up,
        names_of(p),
        POSTS,
        field.GOAL_X,
        STOPS,
    )


def half_field(parameters: HalfFieldParameters = DEFAULT, seed: int = 0) -> KeepawayWorld:
    """Return a world in which half-field attack is played."""
    return KeepawayWorld(parameters, seed, rules_of(parameters))
