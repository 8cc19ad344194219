"""The body of a keeper that reckons with velocities and passes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from keepaway_research.fullspeed.passing import EDGE, NO_LANE, Lane, Moving, Tables
from keepaway_research.predictive.body import PredictiveBody
from keepaway_research.predictive.forecast import HORIZON, Point
from keepaway_world.game.angles import wrapped
from keepaway_world.game.kicking import kick_acceleration, kick_power, off_place
from keepaway_world.parameters import PAPER, KeepawayParameters
from keepaway_world.percept import BALL, HEIGHT, WIDTH

PASS_SPEEDS = (1.8, 2.2, 2.6)  # m/cycle at which a pass may start
FASTEST = 3.0
ENOUGH = 2.0  # m: a lane with more slack is no better
TOO_NEAR = 5.0  # m: no pass to a mate as near as this; it would have no time to correct its way
RUNNING = 0.15  # m/cycle after decay: a mate that is faster runs on until it hears of the pass
SEEN_TO_JUMP = 2.0  # m in a cycle: too far to be a velocity
OWN_JUMP, OTHERS_JUMP = 1.2, 5.0  # m in a cycle: a new episode has begun
ON_ITS_WAY = 12  # cycles for which a yell counts
LATER = 3  # cycles: one who was yelled at goes for the ball even if it is later than another

_YELLED = "pass "


class FullSpeedBody(PredictiveBody):
    """A keeper's body that remembers the last percept and who was passed to.

    Attributes:
        aim: where it stands, or goes to, to support its mates; None if it has no such place.
    """

    __slots__ = ("_awaited", "_before", "_lanes", "_receiver", "_tables", "_velocities", "aim")

    def __init__(self, name: str, parameters: KeepawayParameters = PAPER) -> None:
        super().__init__(name, parameters)
        self._tables = Tables(parameters)
        self.aim: Point | None = None
        self._before: list[Point] = []
        self._velocities: list[Point] = []
        self._receiver, self._awaited = 0, 0
        self._lanes: dict[int, Lane] = {}

    @property
    def tables(self) -> Tables:
        """What players and the ball cover in a number of cycles."""
        return self._tables

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take this cycle's percept, and note velocities and yells."""
        super().sense(values, heard)
        self._lanes = {}
        seen = [self.position, *map(self.place_of, range(self.others.start, len(values), 2))]
        moved = [math.dist(a, b) for a, b in zip(seen, self._before, strict=False)]
        if len(self._before) != len(seen) or moved[0] > OWN_JUMP or max(moved) > OTHERS_JUMP:
            self._before, moved = seen, [0.0] * len(seen)
            self.aim, self._awaited = None, 0
        decay = self.parameters.player_decay
        self._velocities = [
            ((x - was_x) * decay, (y - was_y) * decay) if far < SEEN_TO_JUMP else (0.0, 0.0)
            for (x, y), (was_x, was_y), far in zip(seen, self._before, moved, strict=True)
        ]
        self._before = seen
        self._awaited = max(self._awaited - 1, 0)
        for message in heard:
            if message.startswith(_YELLED) and message[len(_YELLED) :].isdigit():
                self.await_pass(int(message[len(_YELLED) :]))

    def turns(self, angle: float) -> int:
        """Return the number of turns needed to face a direction ``angle`` off the heading."""
        return self._forecaster.turns(angle, self.speed)

    def await_pass(self, number: int) -> None:
        """Note that the ball is on its way to the keeper of this number."""
        self._receiver, self._awaited = number, ON_ITS_WAY

    def moving(self, place: int) -> Moving:
        """Return a player's position and its velocity after decay, from two percepts."""
        index = 1 + (place - self.others.start) // 2
        return *self._before[index], *self._velocities[index]

    @property
    def ball_is_anothers(self) -> bool:
        """Whether the ball is another keeper's: it is nearer, faster, or was passed to."""
        ball = self.place_of(BALL)
        if self.ball_is_kickable:
            own = math.dist(ball, self.position)
            if all(math.dist(ball, self.place_of(mate)) >= own for mate in self.others):
                self._awaited = 0
                return False
            return True
        own, mates = self.cycles_to_meet(self.position), self.soonest_mate()
        if self._awaited and self._receiver == self.number and own <= mates + LATER:
            return False
        if self._awaited and self._receiver != self.number and mates < HORIZON:
            return True
        return mates < own

    @property
    def taker_to_ball(self) -> float:
        """The distance of the nearest taker to the ball, m; infinite without takers."""
        ball = self.place_of(BALL)
        return min((math.dist(ball, self.place_of(t)) for t in self.takers), default=math.inf)

    def lane(self, mate: int) -> Lane:
        """Return the best pass to a teammate; `NO_LANE` if the ball is not kickable."""
        if mate not in self._lanes:
            self._lanes[mate] = self._best_pass(mate) if self.ball_is_kickable else NO_LANE
        return self._lanes[mate]

    def _best_pass(self, mate: int) -> Lane:
        x, y = self.place_of(BALL)
        mate_x, mate_y, mate_vx, mate_vy = self.moving(mate)
        out = self._tables.rolls_out
        if math.hypot(mate_vx, mate_vy) > RUNNING:
            out += 1.0 / self.parameters.player_decay
        to = mate_x + mate_vx * out, mate_y + mate_vy * out
        far = math.dist((x, y), to)
        if far < TOO_NEAR:
            return NO_LANE
        ux, uy = (to[0] - x) / far, (to[1] - y) / far
        takers = [self.moving(taker) for taker in self.takers]
        half = self.values[WIDTH] / 2.0 - EDGE, self.values[HEIGHT] / 2.0 - EDGE
        most = self._speed_along(ux, uy, FASTEST)
        best = NO_LANE
        for speed in sorted({min(speed, most) for speed in PASS_SPEEDS}):
            if speed > 0.0:
                slack = self._tables.slack((x, y), (ux, uy), speed, takers, to, half)
                if min(slack, ENOUGH) > min(best.slack, ENOUGH):
                    best = Lane(slack, ux, uy, speed)
        return best

    def _speed_along(self, ux: float, uy: float, wanted: float) -> float:
        """Return the speed that one kick gives to the ball in a direction, m/cycle."""
        vx, vy = self.ball_velocity
        return vx * ux + vy * uy + self._acceleration(ux, uy, wanted)[0]

    def _acceleration(self, ux: float, uy: float, wanted: float) -> Point:
        p, (vx, vy) = self.parameters, self.ball_velocity
        strongest = 100.0 * p.kick_rate * (1.0 - off_place(p, *self.values[BALL : BALL + 2]))
        return kick_acceleration(p, vx * ux + vy * uy, vy * ux - vx * uy, wanted, strongest)

    def send_ball(self, lane: Lane) -> None:
        """Kick the ball along a lane with its speed."""
        along, across = self._acceleration(lane.ux, lane.uy, lane.speed)
        distance, direction = self.values[BALL : BALL + 2]
        power = kick_power(self.parameters, math.hypot(along, across), distance, direction)
        bearing = math.atan2(lane.uy, lane.ux) + math.atan2(across, along)
        self.kick(min(power, 100.0), wrapped(bearing - self.heading))
