"""The body of a keeper that looks ahead."""

from __future__ import annotations

from collections.abc import Sequence

from keepaway_world import percept
from keepaway_world.body import KeeperBody
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import BALL
from keepaway_world.predictive.forecast import Forecaster, Meeting, Point


class PredictiveBody(KeeperBody):
    """A keeper's body with a forecast of the ball, made on first use in a cycle."""

    __slots__ = ("_forecaster", "_meeting", "_track")

    def __init__(self, name: str, parameters: KeepawayParameters = PAPER) -> None:
        super().__init__(name, parameters)
        self._forecaster = Forecaster(parameters)
        self._track: list[Point] | None = None
        self._meeting: Meeting | None = None

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept; drop the last forecast."""
        super().sense(values, heard)
        self._track = self._meeting = None

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
        x, y = self.position
        dx, dy = self.vector_to(place)
        return x + dx, y + dy

    def cycles_to_meet(self, position: Point) -> int:
        """Return the number of cycles in which a player at a position could meet the ball."""
        return self._forecaster.cycles_to_meet(position, self.ball_track)

    def soonest_mate(self) -> int:
        """Return the number of cycles in which the fastest other keeper could meet the ball."""
        return min(self.cycles_to_meet(self.place_of(place)) for place in self.others)
