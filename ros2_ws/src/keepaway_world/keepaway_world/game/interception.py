"""Interception: where a player first meets a rolling ball, and how to get there.

The ball's track is predicted without noise. For each of the next cycles, turns and dashes towards
the ball's position in that cycle are simulated, as in the UT Austin keepaway players. Horizon and
angle are those of takers recorded on the real simulator. Speeds are in m/cycle.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from keepaway_world.action import Order
from keepaway_world.game.angles import PI, wrapped
from keepaway_world.parameters import KeepawayParameters

if TYPE_CHECKING:  # agents must not need pymunk
    from keepaway_world.game.physics import Mover

SOONEST, HORIZON = 2, 40  # cycles that a player looks ahead
FULL = 100.0
TURNS_MAX = 5
ALIGNED = math.radians(10.0)  # a player that is off by less than this dashes

Point = tuple[float, float]


class Interceptor:
    """Plans interceptions with given mechanics.

    Args:
        parameters: the mechanics.
        dash_factor: factor on the power of the player's dashes; the player knows it.
    """

    def __init__(self, parameters: KeepawayParameters, dash_factor: float = 1.0) -> None:
        self.parameters = p = parameters
        self._power = FULL * dash_factor
        self._kickable = p.kickable
        self._dashed = [0.0]  # m covered from rest by a number of dashes
        self._coasted = [0.0]  # m covered by rolling for a number of cycles, per initial speed
        self._rolled = [0.0]  # likewise for the ball
        speed = 0.0
        for cycle in range(HORIZON):
            speed = min(speed * p.player_decay + self._power * p.dash_rate, p.player_speed_max)
            self._dashed.append(self._dashed[-1] + speed)
            self._coasted.append(self._coasted[-1] + p.player_decay**cycle)
            self._rolled.append(self._rolled[-1] + p.ball_decay**cycle)

    def track(self, ball: Mover) -> list[Point]:
        """Return the ball's positions after 0, 1, ... cycles without a kick, m."""
        x, y, vx, vy = ball.x, ball.y, ball.vx, ball.vy
        return [(x + vx * rolled, y + vy * rolled) for rolled in self._rolled]

    def intercept(self, player: Mover, track: list[Point]) -> tuple[int, Order]:
        """Return the cycles until the player can kick the ball, and its order for this one.

        If the player cannot reach the ball, the cycles are `HORIZON` + 1, and the order leads to
        the end of the track.
        """
        cycles = self._cycles(player, track)
        x, y = track[min(cycles, HORIZON)]
        bearing = math.atan2(y - player.y - player.vy, x - player.x - player.vx)
        off = wrapped(bearing - player.heading)
        if abs(off) > ALIGNED:
            return cycles, turn_by(self.parameters, player, off)
        return cycles, ("dash", self._power, 0.0)

    def _cycles(self, player: Mover, track: list[Point]) -> int:
        kickable = self._kickable
        dashed, coasted = self._dashed, self._coasted
        x, y, vx, vy = player.x, player.y, player.vx, player.vy
        for cycles in range(SOONEST, HORIZON + 1):
            ball_x, ball_y = track[cycles]
            dx, dy = ball_x - x - vx * coasted[cycles], ball_y - y - vy * coasted[cycles]
            far = math.hypot(dx, dy)
            if far - kickable > dashed[cycles]:
                continue  # out of reach even without a turn
            bearing = math.atan2(dy, dx)
            heading, turns = self._turned(player, bearing, cycles)
            reach = dashed[cycles - turns]
            left_x, left_y = dx - reach * math.cos(heading), dy - reach * math.sin(heading)
            if math.hypot(left_x, left_y) < kickable:
                return cycles
        return HORIZON + 1

    def _turned(self, player: Mover, bearing: float, cycles: int) -> tuple[float, int]:
        """Return the heading after the turns needed to face ``bearing``, and their number.

        There are at most ``cycles`` turns, and only a few.
        """
        p = self.parameters
        heading, turns = player.heading, 0
        speed = math.hypot(player.vx, player.vy)
        most_turns = min(cycles, TURNS_MAX)
        while turns < most_turns:
            off = wrapped(bearing - heading)
            if abs(off) <= ALIGNED:
                break
            most = PI / (1.0 + p.inertia * speed)
            heading += min(max(off, -most), most)
            speed *= p.player_decay
            turns += 1
        return heading, turns


def power_to_rest(p: KeepawayParameters, distance: float, ahead: float, most: float) -> float:
    """Return the power of a dash to come to rest after a distance, m, at a speed along it.

    A dash and the rolling out after it cover (speed + acceleration) / (1 - decay).
    """
    power = (distance * (1.0 - p.player_decay) - ahead) / p.dash_rate
    return min(max(power, 0.0), most)


def turn_by(p: KeepawayParameters, player: Mover, angle: float) -> Order:
    """Return the order to turn by ``angle`` rad, or as far as one turn goes at this speed."""
    moment = angle * (1.0 + p.inertia * math.hypot(player.vx, player.vy))
    return "turn", min(max(moment, -PI), PI), 0.0
