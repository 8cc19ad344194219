"""Where the ball will be, and when a keeper can be there.

Each forecast uses only the current percept: the ball's position and velocity as the keeper sees
them. Positions are in m in the world's axes, speeds in m/cycle, times in cycles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from keepaway_world.behaviors import TURN_WHEN_OFF
from keepaway_world.game.angles import PI, wrapped
from keepaway_world.parameters import KeepawayParameters

HORIZON = 40  # cycles to look ahead
FULL = 100.0
COMFORTABLE = 0.6  # m: wanted distance from the ball when they meet

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where and when the ball can be met; ``cycles`` is beyond `HORIZON` if it cannot be."""

    cycles: int
    place: Point


class Forecaster:
    """Forecasts with given mechanics; it holds only tables and can be shared.

    Args:
        parameters: the mechanics that the keeper assumes.
    """

    def __init__(self, parameters: KeepawayParameters) -> None:
        self.parameters = p = parameters
        self._run = [0.0]  # m covered from rest by a number of full dashes
        self._coasted = [0.0]  # m covered by rolling out, per initial speed
        self._rolled = [0.0]  # likewise for the ball
        speed = 0.0
        for cycle in range(HORIZON):
            speed = min(speed * p.player_decay + FULL * p.dash_rate, p.player_speed_max)
            self._run.append(self._run[-1] + speed)
            self._coasted.append(self._coasted[-1] + p.player_decay**cycle)
            self._rolled.append(self._rolled[-1] + p.ball_decay**cycle)

    def track(self, ball: Point, velocity: Point, size: Point) -> list[Point]:
        """Return the ball's positions in 0, 1, ... cycles without a kick.

        The track ends with the last cycle inside the box, which has this ``size``.
        """
        (x, y), (vx, vy) = ball, velocity
        half_width, half_height = size[0] / 2.0, size[1] / 2.0
        end_x, end_y = x + vx * self._rolled[-1], y + vy * self._rolled[-1]
        if max(abs(x), abs(end_x)) < half_width and max(abs(y), abs(end_y)) < half_height:
            return [ball, *[(x + vx * rolled, y + vy * rolled) for rolled in self._rolled[1:]]]
        track = [ball]
        for rolled in self._rolled[1:]:
            there_x, there_y = x + vx * rolled, y + vy * rolled
            if abs(there_x) >= half_width or abs(there_y) >= half_height:
                break
            track.append((there_x, there_y))
        return track

    def meet(
        self, position: Point, heading: float, velocity: Point, track: Sequence[Point]
    ) -> Meeting:
        """Return where a keeper can first meet the ball, including turns.

        If it cannot meet the ball, this is the end of the track.
        """
        (x, y), (vx, vy) = position, velocity
        speed = math.hypot(vx, vy)
        for cycles in range(1, len(track)):
            place = track[cycles]
            coasted = self._coasted[cycles]
            dx, dy = place[0] - x - vx * coasted, place[1] - y - vy * coasted
            far = math.hypot(dx, dy) - COMFORTABLE
            if far <= 0.0:
                return Meeting(cycles, place)
            if far > self._run[cycles]:
                continue
            turns = self.turns(wrapped(math.atan2(dy, dx) - heading), speed)
            if turns < cycles and far <= self._run[cycles - turns]:
                return Meeting(cycles, place)
        return Meeting(HORIZON + 1, track[-1])

    def turns(self, angle: float, speed: float) -> int:
        """Return the number of turns needed to face a direction ``angle`` off the heading."""
        off, turns = abs(angle), 0
        while off > TURN_WHEN_OFF:
            off -= PI / (1.0 + self.parameters.inertia * speed)
            speed *= self.parameters.player_decay
            turns += 1
        return turns

    def cycles_to_meet(self, position: Point, track: Sequence[Point]) -> int:
        """Return the number of cycles in which a player could meet the ball, ignoring its heading.

        This compares players of which only the position is known.
        """
        x, y = position
        ball_speed = math.dist(track[0], track[1]) if len(track) > 1 else 0.0
        closing = self.parameters.player_speed_max + ball_speed  # m/cycle, at most
        cycles = 0
        while cycles < len(track):
            place = track[cycles]
            left = math.hypot(place[0] - x, place[1] - y) - COMFORTABLE - self._run[cycles]
            if left <= 0.0:
                return cycles
            cycles += max(1, int(left / closing))
        end = track[-1]
        return HORIZON + math.ceil(math.hypot(end[0] - x, end[1] - y))
