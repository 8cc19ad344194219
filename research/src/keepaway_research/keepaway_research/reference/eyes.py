"""A reference player's view of the field: what it sees, expects and remembers."""

from __future__ import annotations

import cmath
import math

from keepaway_research.reference.view import Seen, View
from keepaway_world.action import Order
from keepaway_world.game.angles import wrapped
from keepaway_world.game.kicking import off_place
from keepaway_world.game.physics import REBOUND, Mover, Physics
from keepaway_world.game.sight import quantised_direction, quantised_distance, seen_velocity
from keepaway_world.parameters import KeepawayParameters

SIGHT_CYCLES, BLIND = 3, 2  # in one of three cycles a player sees nothing new
CHASING = 0.3  # m/cycle: assumed speed of the opponent nearest to the ball, towards it
STROLLING = 0.25  # m/cycle: assumed speed of the others, in the ball's direction
FAST = 1.0  # m/cycle: if the ball is faster, they are assumed to be twice as fast
STILL, SLOW = 0.005, 0.08  # m/cycle: lower speeds count as zero, or as slow
BESIDE = 0.8  # m: a ball this close may have stopped the player
TOUCHING = 0.2  # m: assumed distance of a ball that the player ran into

NOTHING: Order = ("dash", 0.0, 0.0)


class Eyes:
    """Looks at the field for one player, and remembers what it saw.

    Its sight is the game's `sight`: exact and in every cycle, or quantised and in two of three
    cycles, as rcssserver sends it (every 150 ms). In between it estimates all positions. It knows
    its own position exactly, as on the real simulator, where many flags surround the field.

    Args:
        physics: the true field.
        me: the player that looks.
    """

    def __init__(self, physics: Physics, me: Mover) -> None:
        self._physics = physics
        self._me = me
        keeper = me.kind == "keeper"
        self._opponents = [m.name for m in (physics.takers if keeper else physics.keepers)]
        self._mates = [m.name for m in (physics.keepers if keeper else physics.takers)]
        self._forward = 1.0 if keeper else -1.0
        self.begin()

    def begin(self) -> None:
        """Forget the last episode."""
        self._cycle = 0
        self._order: Order = NOTHING
        self._memory: dict[str, Seen] = {}

    def view(self) -> View:
        """Return the player's estimate of the field; call once per cycle."""
        physics, me = self._physics, self._me
        if physics.parameters.sight == "full":
            seen = {mover.name: _exactly(mover) for mover in physics.movers}
        else:
            expected = self._reckon()
            if expected and self._cycle % SIGHT_CYCLES == BLIND:
                seen = expected
            else:
                seen = {mover.name: _quantised(me, mover) for mover in physics.movers}
                self._steady(seen, expected)
        self._cycle += 1
        self._order = NOTHING
        self._memory = seen
        return View(
            physics.parameters,
            seen[me.name],
            seen[physics.ball.name],
            [seen[keeper.name] for keeper in physics.keepers],
            [seen[taker.name] for taker in physics.takers],
        )

    def did(self, order: Order) -> None:
        """Record the player's command in this cycle, to predict its effect."""
        self._order = order

    def _reckon(self) -> dict[str, Seen]:
        """Return the expected positions one cycle after those remembered."""
        if not self._memory:
            return {}
        p, me = self._physics.parameters, self._me
        seen = {name: one.copy() for name, one in self._memory.items()}
        myself, ball = seen[me.name], seen["ball"]
        speed = math.hypot(myself.vx, myself.vy)
        kind, amount, direction = self._order
        velocity = complex(ball.vx, ball.vy)
        if kind == "kick":
            velocity += _kick(p, myself, ball, amount, direction)
        _roll(ball, velocity, p.ball_decay)
        heading = myself.heading + (amount / (1.0 + p.inertia * speed) if kind == "turn" else 0.0)
        moving = complex(myself.vx, myself.vy)
        if kind == "dash":
            moving += cmath.rect(amount * p.dash_rate, myself.heading)
        myself = seen[me.name] = _exactly(me)
        myself.heading = wrapped(heading)
        if p.ball_collides and _felt(p, moving * p.player_decay, myself, ball):
            away = cmath.rect(TOUCHING, math.atan2(ball.y - me.y, ball.x - me.x))
            ball.x, ball.y = me.x + away.real, me.y + away.imag
            ball.vx, ball.vy = ball.vx * REBOUND, ball.vy * REBOUND
        for name in self._mates:
            if name != me.name:
                mate = seen[name]
                _roll(mate, complex(mate.vx, mate.vy), p.player_decay)
        self._reckon_opponents(seen, self._forward * velocity.real)
        return seen

    def _reckon_opponents(self, seen: dict[str, Seen], ahead: float) -> None:
        """Move the opponents as assumed: one to the ball, the others along with it.

        A ball that one of them can kick is assumed to be at rest.

        Args:
            seen: all positions; modified in place.
            ahead: the ball's velocity in the direction in which the team plays, m/cycle.
        """
        p, ball = self._physics.parameters, seen["ball"]
        fastest = min(self._opponents, key=lambda name: _apart(seen[name], ball), default="")
        for name in self._opponents:
            opponent = seen[name]
            if name == fastest:
                away = complex(ball.x - opponent.x, ball.y - opponent.y)
                step = cmath.rect(CHASING, cmath.phase(away))
            else:
                step = complex(self._forward * (1.0 if ahead > 0.0 else -1.0))
                step *= STROLLING * (2.0 if abs(ahead) > FAST else 1.0)
            opponent.x, opponent.y = opponent.x + step.real, opponent.y + step.imag
            opponent.vx, opponent.vy = opponent.vx * p.player_decay, opponent.vy * p.player_decay
            if _apart(opponent, ball) < p.kickable:
                ball.vx = ball.vy = 0.0

    def _steady(self, seen: dict[str, Seen], expected: dict[str, Seen]) -> None:
        """Correct the ball's velocity by the expected one.

        These players assume that a ball is at rest if an opponent can kick it and they cannot.
        """
        p, ball = self._physics.parameters, seen["ball"]
        if _apart(ball, seen[self._me.name]) > p.kickable and any(
            _apart(ball, seen[name]) < p.kickable for name in self._opponents
        ):
            ball.vx = ball.vy = 0.0
        elif expected:
            before = expected["ball"]
            allowed = 2.0 * p.ball_rand * math.hypot(before.vx, before.vy)
            if abs(ball.vx - before.vx) <= allowed and abs(ball.vy - before.vy) <= allowed:
                ball.vx, ball.vy = (ball.vx + before.vx) / 2.0, (ball.vy + before.vy) / 2.0


def _felt(p: KeepawayParameters, expected: complex, me: Seen, ball: Seen) -> bool:
    """Whether a player assumes that it ran into the ball: it is slower than expected, or turned.

    Args:
        p: of the game.
        expected: its own velocity, had there been no collision.
        me: its actual state.
        ball: its expected state.
    """
    distance, speed = _apart(me, ball), math.hypot(me.vx, me.vy)
    if speed < STILL:
        return distance < p.contact or (distance < BESIDE and abs(expected) > 2.0 * STILL)
    return (
        distance < p.kickable + 0.5
        and speed < 0.25 * abs(expected)
        and (me.vx * expected.real <= 0.0 or abs(expected.real) < SLOW)
        and (me.vy * expected.imag <= 0.0 or abs(expected.imag) < SLOW)
    )


def _apart(one: Seen, other: Seen) -> float:
    return math.hypot(one.x - other.x, one.y - other.y)


def _roll(one: Seen, velocity: complex, decay: float) -> None:
    one.x, one.y = one.x + velocity.real, one.y + velocity.imag
    one.vx, one.vy = velocity.real * decay, velocity.imag * decay


def _kick(p: KeepawayParameters, me: Seen, ball: Seen, power: float, direction: float) -> complex:
    """Return the ball's acceleration, m/cycle², that a player expects from its kick."""
    dx, dy = ball.x - me.x, ball.y - me.y
    distance = math.hypot(dx, dy)
    if distance > p.kickable:
        return 0j
    aside = wrapped(math.atan2(dy, dx) - me.heading) if distance else 0.0
    rate = p.kick_rate * (1.0 - off_place(p, distance, aside))
    return cmath.rect(min(power * rate, p.ball_acceleration_max), me.heading + direction)


def _exactly(other: Mover) -> Seen:
    return Seen(other.name, other.x, other.y, other.vx, other.vy, other.heading)


def _quantised(me: Mover, other: Mover) -> Seen:
    """Return an object as a player of rcssserver sees it; see `keepaway_world.game.sight`."""
    if other is me:
        return _exactly(me)
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
