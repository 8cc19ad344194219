"""By how much the takers miss a pass on its way: in time, not only in distance.

The ball is followed cycle by cycle until the receiver can have it. In each cycle, a taker's reach
is what it has run by then, from where it coasts to, plus its kicking range. Lengths are in m,
times in cycles, speeds in m/cycle.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

from keepaway_research.predictive.forecast import Point
from keepaway_world.parameters import KeepawayParameters

HORIZON = 40  # cycles in the tables
PASS_CYCLES = 14  # a pass that takes longer is not considered
REACTION = 1  # cycles until a taker runs the right way
RECEIVER_TURNS = 2  # cycles until a receiver does
AT_FOOT = 0.5  # m: a receiver this near to the ball's path need not run
EDGE = 1.2  # m from the edge of the box: nobody is passed to beyond it
HOPELESS = -2.0  # m: no need to know how bad a lane is beyond this
BLOCKED = -9.0
"""Slack of a lane on which the ball does not arrive, m."""

Moving = tuple[float, float, float, float]
"""A player's position and its velocity after decay: x, y, vx, vy."""


@dataclass(frozen=True, slots=True)
class Lane:
    """A pass that could be made.

    Attributes:
        slack: by how much the nearest taker misses the ball on its way, m; below 0 it does not.
        ux, uy: direction.
        speed: with which the ball starts, m/cycle.
    """

    slack: float
    ux: float
    uy: float
    speed: float


NO_LANE = Lane(BLOCKED, 1.0, 0.0, 0.0)


class Tables:
    """What players and the ball cover in a number of cycles, with given mechanics.

    Attributes:
        run: m that a player runs from rest.
        coasted, rolled: m covered without a dash or a kick, per speed, by a player and the ball.
    """

    def __init__(self, parameters: KeepawayParameters) -> None:
        p = parameters
        self.kickable, self.ball_decay = p.kickable, p.ball_decay
        self.run, self.coasted, self.rolled = [0.0], [0.0], [0.0]
        speed = 0.0
        for cycle in range(HORIZON):
            speed = min(speed * p.player_decay + 100.0 * p.dash_rate, p.player_speed_max)
            self.run.append(self.run[-1] + speed)
            self.coasted.append(self.coasted[-1] + p.player_decay**cycle)
            self.rolled.append(self.rolled[-1] + p.ball_decay**cycle)
        self.rolls_out = 1.0 / (1.0 - p.player_decay)
        self._slowing, self._log_decay = 1.0 - p.ball_decay, math.log(p.ball_decay)
        delays = [max(0, cycle - REACTION) for cycle in range(HORIZON)]
        self._reach = [self.run[cycle] + self.kickable for cycle in delays]  # of a taker
        delays = [max(0, cycle - RECEIVER_TURNS) for cycle in range(HORIZON)]
        self._arrives = [0.9 * self.run[cycle] + AT_FOOT for cycle in delays]  # of a receiver

    def cycles_to_run(self, distance: float) -> int:
        """Return the number of cycles in which a player runs so far; at most `HORIZON`."""
        return min(bisect_left(self.run, distance), HORIZON)

    def time_to_roll(self, distance: float, speed: float) -> float:
        """Return the time in which a ball rolls so far, in cycles and parts; at most `HORIZON`."""
        left = 1.0 - distance * self._slowing / speed
        return math.log(left) / self._log_decay if left > 0.0 else float(HORIZON)

    def slack(
        self,
        ball: Point,
        direction: Point,
        speed: float,
        takers: Sequence[Moving],
        receiver: Point,
        half: Point,
    ) -> float:
        """Return the slack of a pass, m, or `BLOCKED` if its receiver cannot have it.

        Args:
            ball: where it starts.
            direction: unit vector.
            speed: with which it starts.
            takers: who might reach it.
            receiver: where the receiver comes to rest if it does nothing.
            half: of the width and of the height within which the pass must arrive.
        """
        (x, y), (ux, uy), (mate_x, mate_y) = ball, direction, receiver
        half_width, half_height = half
        hypot, least = math.hypot, math.inf
        for cycle in range(1, PASS_CYCLES + 1):
            rolled = speed * self.rolled[cycle]
            ball_x, ball_y = x + ux * rolled, y + uy * rolled
            if abs(ball_x) > half_width or abs(ball_y) > half_height:
                return BLOCKED
            reach, coast = self._reach[cycle], self.coasted[cycle]
            for taker_x, taker_y, vx, vy in takers:
                away = hypot(ball_x - taker_x - vx * coast, ball_y - taker_y - vy * coast)
                if away - reach < least:
                    least = away - reach
            if least < HOPELESS or hypot(ball_x - mate_x, ball_y - mate_y) <= self._arrives[cycle]:
                return least
        return BLOCKED
