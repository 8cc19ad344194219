"""The body of a keeper that looks ahead."""

from __future__ import annotations

import math
from collections.abc import Sequence

from keepaway_research.predictive.forecast import Forecaster, Meeting, Point
from keepaway_world import percept
from keepaway_world.body import KeeperBody
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import BALL


class PredictiveBody(KeeperBody):
    """A keeper's body with a forecast of the ball; what it works out is kept for the cycle."""

    __slots__ = ("_forecaster", "_meeting", "_places", "_soonest", "_track")

    def __init__(self, name: str, parameters: KeepawayParameters = PAPER) -> None:
        super().__init__(name, parameters)
        self._forecaster = Forecaster(parameters)
        self._track: list[Point] | None = None
        self._meeting: Meeting | None = None
        self._places: dict[int, Point] = {}
        self._soonest: dict[Point, int] = {}

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept; drop the last forecast."""
        super().sense(values, heard)
        self._track = self._meeting = None
        self._places, self._soonest = {}, {}

    @property
    def ball_track(self) -> list[Point]:
        """Where the ball will be in 0, 1, ... cycles, within the box, m."""
        if self._track is None:
            size = self.values[percept.WIDTH], self.values[percept.HEIGHT]
            self._track = self._forecaster.track(self.place_of(BALL), self.ball_velocity, size)
        return self._track

    @property
    def meeting(self) -> Meeting:
        """Where this keeper can first meet the ball."""
        if self._meeting is None:
            self._meeting = self._forecaster.meet(
                self.position, self.heading, self.velocity, self.ball_track
            )
        return self._meeting

    def place_of(self, place: int) -> Point:
        """Return the position of the ball or a player in the world, m."""
        found = self._places.get(place)
        if found is None:
            values = self.values
            distance, bearing = values[place], values[percept.HEADING] + values[place + 1]
            found = self._places[place] = (
                values[percept.X] + distance * math.cos(bearing),
                values[percept.Y] + distance * math.sin(bearing),
            )
        return found

    def cycles_to_meet(self, position: Point) -> int:
        """Return the number of cycles in which a player at a position could meet the ball."""
        cycles = self._soonest.get(position)
        if cycles is None:
            cycles = self._forecaster.cycles_to_meet(position, self.ball_track)
            self._soonest[position] = cycles
        return cycles

    def soonest_mate(self) -> int:
        """Return the number of cycles in which the fastest other keeper could meet the ball."""
        return min(self.cycles_to_meet(self.place_of(place)) for place in self.others)
