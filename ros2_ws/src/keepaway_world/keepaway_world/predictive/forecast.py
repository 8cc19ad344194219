"""Where the ball will be, and when a keeper can be there.

A forecast is made afresh from each percept, of where the ball is and how it moves as far as the
keeper sees. Positions are in m in the world's axes, speeds in m/cycle, times in cycles.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from keepaway_world.angles import PI, wrapped
from keepaway_world.behaviors import TURN_WHEN_OFF
from keepaway_world.parameters import KeepawayParameters

HORIZON = 40  # cycles that are looked ahead
FULL = 100.0
COMFORTABLE = 0.6  # m: a keeper wants to be so near to the ball when they meet

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where and when the ball can be met; ``cycles`` is beyond `HORIZON` if it cannot be."""

    cycles: int
    place: Point


class Forecaster:
    """Forecasts with given mechanics; it holds tables alone and can be shared.

    Args:
        parameters: the mechanics that the keeper believes in.
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
        """Return where the ball will be in 0, 1, ... cycles if nobody kicks it.

        It is followed up to the last cycle within the box, which is ``size`` large.
        """
        (x, y), (vx, vy) = ball, velocity
        half_width, half_height = size[0] / 2.0, size[1] / 2.0
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
        """Return where a keeper can first meet the ball, turns included.

        If it cannot, it is the end of the track, to which it can at least go.
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
        """Return how many turns it takes to face a direction that is so far off."""
        off, turns = abs(angle), 0
        while off > TURN_WHEN_OFF:
            off -= PI / (1.0 + self.parameters.inertia * speed)
            speed *= self.parameters.player_decay
            turns += 1
        return turns

    def cycles_to_meet(self, position: Point, track: Sequence[Point]) -> int:
        """Return in how many cycles a player could meet the ball, whatever way it faces.

        For comparing players of whom no more is known than where they are.
        """
        x, y = position
        for cycles in range(len(track)):
            place = track[cycles]
            if math.hypot(place[0] - x, place[1] - y) - COMFORTABLE <= self._run[cycles]:
                return cycles
        end = track[-1]
        return HORIZON + math.ceil(math.hypot(end[0] - x, end[1] - y))
