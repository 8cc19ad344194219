"""The keepaway referee: ends and sets up episodes, and counts passes and possession.

The rules are those of rcssserver's keepaway mode, with y pointing up.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from random import Random
from typing import Any

from hitab_world.simulating.snapshots import finite, whole
from keepaway_world.game.physics import Mover, Physics
from keepaway_world.parameters import KeepawayParameters

OUT = "out"
TAKEN = "taken"

CORNER_SPREAD = 3.0  # m: players begin up to this far inside their corner, in x and in y
CLEAR_DISTANCE = 9.15  # m from a dropped ball to the edge of the nearest player
BALL_INSET = 4.0  # m: the ball begins this far inside its corner
KEEPER_CORNERS = ((-1.0, 1.0), (1.0, 1.0), (1.0, -1.0))
TAKER_CORNER = (-1.0, -1.0)


class Referee:
    """The referee of one episode at a time.

    Attributes:
        possession: cycles of possession by takers so far; see `judge`.
        passes: completed passes: a keeper's kick followed by another keeper's.
    """

    def __init__(self, parameters: KeepawayParameters) -> None:
        self._keepers = parameters.keepers
        self._turnover = parameters.turnover_cycles
        self._half_width = parameters.width / 2.0
        self._half_height = parameters.height / 2.0
        self._kickable_squared = parameters.kickable**2
        self._stuck_area = parameters.stuck_area
        self._drop_ball = parameters.drop_ball_cycles
        self.begin()

    def begin(self) -> None:
        """Forget the last episode."""
        self.possession = self.passes = 0
        self._last_kick: Mover | None = None
        self._stuck_at = (0.0, 0.0)
        self._stuck_for = 0

    def saw_kick(self, player: Mover) -> None:
        """Note that ``player`` kicked the ball."""
        last = self._last_kick
        if last and last is not player and max(last.index, player.index) <= self._keepers:
            self.passes += 1
        self._last_kick = player

    def judge(self, physics: Physics) -> str | None:
        """Check the state after a cycle; return `OUT`, `TAKEN` or None.

        The ball is out when its center reaches an edge. Possession increases in each cycle in
        which a taker can kick, returns to 0 if a keeper but no taker can, and stays if no player
        can. The ball is taken on the check after possession has reached the limit.
        """
        ball = physics.ball
        if line := self.crossed(ball):
            return line
        bx, by = ball.x, ball.y
        if self.possession >= self._turnover:
            return TAKEN
        reach = self._kickable_squared
        for taker in physics.takers:
            dx, dy = taker.x - bx, taker.y - by
            if dx * dx + dy * dy < reach:
                self.possession += 1
                return None
        for keeper in physics.keepers:
            dx, dy = keeper.x - bx, keeper.y - by
            if dx * dx + dy * dy < reach:
                self.possession = 0
                return None
        return None

    def crossed(self, ball: Mover) -> str:
        """Return why a ball in this place ends the episode; "" if the episode continues."""
        out = abs(ball.x) >= self._half_width or abs(ball.y) >= self._half_height
        return OUT if out else ""

    def saw_catch(self, player: Mover) -> None:
        """Note that a taker has tried to catch the ball, which keepaway does not allow."""

    def measures(self, ended: str) -> dict[str, float]:
        """Return the measures of the episode so far; ``ended`` is its end's reason, or ""."""
        return {"passes": float(self.passes)}

    def finds_stuck(self, ball: Mover) -> bool:
        """Check after a cycle whether the ball has been near the same place for too long.

        This is rcssserver's rule, with ``ball_stuck_area`` and ``drop_ball_time``; see
        `drop_ball`.
        """
        x, y = self._stuck_at
        if math.hypot(ball.x - x, ball.y - y) <= self._stuck_area:
            self._stuck_for += 1
            if self._stuck_for < self._drop_ball:
                return False
        self._stuck_at = ball.x, ball.y
        stuck = self._stuck_for >= self._drop_ball
        self._stuck_for = 0
        return stuck and self._stuck_area > 0.0

    def state(self) -> dict[str, Any]:
        """Return the referee's counts as JSON-serializable data."""
        last = self._last_kick.name if self._last_kick else ""
        return {
            "possession": self.possession,
            "passes": self.passes,
            "last_kick": last,
            "stuck_at": list(self._stuck_at),
            "stuck_for": self._stuck_for,
        }

    def restore(self, state: Mapping[str, Any], players: Sequence[Mover]) -> None:
        """Restore what `state` returned.

        Raises:
            KeyError, TypeError, ValueError: if it is not such a state; nothing has changed.
        """
        possession, passes, stuck_for = (
            whole(state[name]) for name in ("possession", "passes", "stuck_for")
        )
        x, y = map(finite, state["stuck_at"])
        kickers = {"": None, **{player.name: player for player in players}}
        self._last_kick = kickers[state["last_kick"]]
        self.possession, self.passes = possession, passes
        self._stuck_at, self._stuck_for = (x, y), stuck_for


def drop_ball(physics: Physics) -> None:
    """Stop the ball where it is and move nearby players straight away from it."""
    ball = physics.ball
    physics.put(ball, ball.x, ball.y)
    for player in physics.players:
        away = math.hypot(player.x - ball.x, player.y - ball.y)
        clear = CLEAR_DISTANCE + player.radius
        if 0.0 < away < clear:
            x = ball.x + (player.x - ball.x) * clear / away
            y = ball.y + (player.y - ball.y) * clear / away
            physics.put(player, x, y, player.heading)


def set_up(physics: Physics, random: Random) -> None:
    """Put all players and the ball in their initial positions, at rest.

    The keepers stand in three corners, in a random rotation; any beyond three near the center.
    The takers stand in the fourth corner, the ball 4 m inside the first.
    """
    p = physics.parameters
    drawn = p.reset_angles == "drawn"
    rotation = random.randrange(p.keepers)
    for number, player in enumerate(physics.players):
        if player in physics.takers:
            x, y = _in_corner(TAKER_CORNER, p, random)
        else:
            place = (rotation + number) % p.keepers
            if place < len(KEEPER_CORNERS):
                x, y = _in_corner(KEEPER_CORNERS[place], p, random)
            else:
                x, y = random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)
        heading = random.uniform(-math.pi, math.pi) if drawn else player.heading
        physics.put(player, x, y, heading)
    physics.put(physics.ball, *ball_start(p))


def ball_start(p: KeepawayParameters) -> tuple[float, float]:
    """Return where the ball begins, m."""
    corner_x, corner_y = KEEPER_CORNERS[0]
    return corner_x * (p.width / 2.0 - BALL_INSET), corner_y * (p.height / 2.0 - BALL_INSET)


def _in_corner(
    corner: tuple[float, float], p: KeepawayParameters, random: Random
) -> tuple[float, float]:
    x = corner[0] * (p.width / 2.0 - random.uniform(0.0, CORNER_SPREAD))
    y = corner[1] * (p.height / 2.0 - random.uniform(0.0, CORNER_SPREAD))
    return x, y
