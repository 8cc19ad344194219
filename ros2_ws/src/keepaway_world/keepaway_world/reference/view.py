"""What a reference player takes the field to be: exactly as it is, or as far as it can see."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import dataclass

from keepaway_world.angles import wrapped
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.physics import Mover, Physics
from keepaway_world.sight import quantised_direction, quantised_distance, seen_velocity


@dataclass(slots=True)
class Seen:
    """The ball or a player as it is taken to be; position in m, velocity in m/cycle."""

    name: str
    x: float
    y: float
    vx: float
    vy: float
    heading: float = 0.0


@dataclass(slots=True)
class View:
    """The field in one cycle, as one player takes it to be.

    Attributes:
        parameters: of the game, the same for all.
        me: who looks; one of the players.
        ball, keepers, takers: all that there is.
    """

    parameters: KeepawayParameters
    me: Seen
    ball: Seen
    keepers: Sequence[Seen]
    takers: Sequence[Seen]

    @property
    def players(self) -> list[Seen]:
        """All players, who looks included."""
        return [*self.keepers, *self.takers]


class Eyes:
    """Looks at the field for one player; remembers the ball's velocity from cycle to cycle.

    How well it sees is the game's `sight`. Where the player itself stands and what it faces, it
    knows exactly: on the real simulator the many flags around the field tell.

    Args:
        physics: the field as it is.
        me: who looks.
    """

    def __init__(self, physics: Physics, me: Mover) -> None:
        self._physics = physics
        self._me = me
        self._opponents = physics.takers if me.kind == "keeper" else physics.keepers
        self._look = _exactly if physics.parameters.sight == "full" else _quantised
        self._velocity: complex | None = None

    def begin(self) -> None:
        """Forget the last episode."""
        self._velocity = None

    def view(self) -> View:
        """Return what the player takes the field to be now."""
        physics, me = self._physics, self._me
        seen = {mover.name: self._look(me, mover) for mover in physics.movers}
        ball = seen[physics.ball.name]
        if physics.parameters.sight != "full":
            velocity = self._velocity_of(ball, seen)
            ball.vx, ball.vy = velocity.real, velocity.imag
            self._velocity = velocity * physics.parameters.ball_decay
        return View(
            physics.parameters,
            seen[me.name],
            ball,
            [seen[keeper.name] for keeper in physics.keepers],
            [seen[taker.name] for taker in physics.takers],
        )

    def _velocity_of(self, ball: Seen, seen: dict[str, Seen]) -> complex:
        """Return the ball's velocity: as seen, steadied by what was expected of it.

        These players take a ball that an opponent can kick, and they cannot, to be at rest.
        """
        p, me = self._physics.parameters, self._me
        if math.hypot(ball.x - me.x, ball.y - me.y) > p.kickable and any(
            math.hypot(ball.x - seen[o.name].x, ball.y - seen[o.name].y) < p.kickable
            for o in self._opponents
        ):
            return 0j
        velocity, expected = complex(ball.vx, ball.vy), self._velocity
        if expected is not None:
            allowed = 2.0 * p.ball_rand * abs(expected)
            off = velocity - expected
            if abs(off.real) <= allowed and abs(off.imag) <= allowed:
                velocity = (velocity + expected) / 2.0
        return velocity


def _exactly(me: Mover, other: Mover) -> Seen:
    return Seen(other.name, other.x, other.y, other.vx, other.vy, other.heading)


def _quantised(me: Mover, other: Mover) -> Seen:
    """Return how a player of rcssserver sees something; see `keepaway_world.sight`."""
    if other is me:
        return _exactly(me, me)
    dx, dy = other.x - me.x, other.y - me.y
    distance = quantised_distance(math.hypot(dx, dy))
    bearing = me.heading + quantised_direction(wrapped(math.atan2(dy, dx) - me.heading))
    vx, vy = seen_velocity(dx, dy, other.vx - me.vx, other.vy - me.vy, distance, bearing)
    place = cmath.rect(distance, bearing)
    heading = me.heading + quantised_direction(wrapped(other.heading - me.heading))
    return Seen(
        other.name,
        me.x + place.real,
        me.y + place.imag,
        me.vx + vx,
        me.vy + vy,
        wrapped(heading),
    )
