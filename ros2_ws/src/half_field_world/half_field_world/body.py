"""An attacker's body: fixed places, and by how much opponents would miss a ball."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType

from half_field_world import field
from keepaway_world.body import CORNERS, NO_PLAYER, KeeperBody
from keepaway_world.game.kicking import off_place, pass_speed
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import BALL

Point = tuple[float, float]

GOAL, SPOT, LEFT_WING, RIGHT_WING = -6, -7, -8, -9
FIXED = MappingProxyType(
    {
        **CORNERS,
        GOAL: (1.0, 0.0),
        SPOT: (1.0 - 11.0 / field.GOAL_X, 0.0),
        LEFT_WING: (1.0 - 13.0 / field.GOAL_X, 15.0 / (field.WIDTH / 2.0)),
        RIGHT_WING: (1.0 - 13.0 / field.GOAL_X, -15.0 / (field.WIDTH / 2.0)),
    }
)
"""The corners, the middle of the goal, the penalty spot and two places on the wings."""

AIMS = tuple(part * (field.GOAL_WIDTH / 2.0 - 0.8) for part in (-1.0, -0.5, 0.0, 0.5, 1.0))
"""The y coordinates on the goal line at which shots are aimed, m."""

LATE = 1  # number of cycles until an opponent runs at full speed
AT_FOOT = 1.0  # m: distance from the receiver at which a pass has arrived


@dataclass(frozen=True, slots=True)
class BallPath:
    """A path along which the ball can be kicked.

    Attributes:
        slack: distance by which the opponents miss the ball, m; negative if they can reach it.
        bearing: in the world's axes, rad.
    """

    slack: float
    bearing: float


class AttackerBody(KeeperBody):
    """The `hitab_core.domain.Body` of an attacker."""

    fixed = FIXED

    def __init__(self, name: str, parameters: KeepawayParameters = PAPER) -> None:
        super().__init__(name, parameters)
        self._lines: dict[int, BallPath] = {}

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept; clear the last one and its command."""
        super().sense(values, heard)
        self._lines.clear()

    def at(self, place: int) -> Point:
        """Return the position of a thing, m."""
        x, y = self.position
        if place in self.fixed:
            right, up = self.fixed[place]
            return right * field.LENGTH / 2.0, up * field.WIDTH / 2.0
        dx, dy = self.vector_to(place)
        return x + dx, y + dy

    def line_to(self, place: int) -> BallPath:
        """Return the ball's path for a pass to a mate, or for the best shot at `GOAL`."""
        if place not in self._lines:
            ball = self.at(BALL)
            if place == GOAL:
                shots = [self._line(ball, (field.GOAL_X, y), 0.0) for y in AIMS]
                self._lines[place] = max(shots, key=lambda line: line.slack)
            else:
                self._lines[place] = self._line(ball, self.at(place), AT_FOOT)
        return self._lines[place]

    def _line(self, ball: Point, to: Point, short: float) -> BallPath:
        p, (x, y) = self.parameters, ball
        far, bearing = math.dist(ball, to), math.atan2(to[1] - y, to[0] - x)
        ux, uy = math.cos(bearing), math.sin(bearing)
        off = off_place(p, *self.values[BALL : BALL + 2]) if self.ball_is_kickable else 0.25
        speed = 100.0 * p.kick_rate * (1.0 - off)
        if short:
            speed = min(speed, pass_speed(p, far))
        opponents = [self.at(taker) for taker in self.takers]
        rolled, cycle, slack = 0.0, 0, math.inf
        while rolled < far - short:
            if speed < 0.3:
                return BallPath(-far, bearing)  # it does not get there
            rolled, cycle, speed = rolled + speed, cycle + 1, speed * p.ball_decay
            at_x, at_y = x + ux * rolled, y + uy * rolled
            reach = max(cycle - LATE, 0) * p.player_speed_max + p.kickable
            for other_x, other_y in opponents:
                slack = min(slack, math.hypot(at_x - other_x, at_y - other_y) - reach)
        return BallPath(min(slack, far), bearing)

    def best_mate(self) -> int:
        """Return the mate to pass to: the most advanced in reach of a pass, else the freest."""

        def worth(mate: int) -> tuple[bool, float]:
            slack = self.line_to(mate).slack
            free = slack > 0.0
            return free, -math.dist(self.at(mate), self.at(GOAL)) if free else slack

        return max(self.others, key=worth, default=NO_PLAYER)

    def near_wing(self) -> int:
        """Return the place on the wing on the ball's side."""
        return LEFT_WING if self.at(BALL)[1] > 0.0 else RIGHT_WING

    def far_wing(self) -> int:
        """Return the place on the other wing."""
        return RIGHT_WING if self.near_wing() == LEFT_WING else LEFT_WING
