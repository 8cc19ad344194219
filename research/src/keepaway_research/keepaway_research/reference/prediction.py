"""Predicts a player's own motion and finds the commands to reach a place."""

from __future__ import annotations

import cmath
import math
from dataclasses import dataclass

from keepaway_research.reference.view import Seen
from keepaway_world.action import Order
from keepaway_world.game.angles import PI, wrapped
from keepaway_world.parameters import KeepawayParameters

FULL = 100.0
LATERAL = 0.9  # of the kicking range: a point closer to the path needs no turn
LATERAL_FAR = ((20.0, 3.0), (10.0, 2.0))  # likewise beyond these distances, m
BEHIND = 2.5  # m: a point behind the player, nearer than this, may be reached backwards
TURNS_MAX = 5
ROLLING = 4  # cycles of rolling out that are considered
ROUNDING = 1e-9  # m: more than what rounding can add up to


@dataclass(slots=True)
class Motion:
    """A player's expected motion: position, velocity after decay, heading."""

    position: complex
    velocity: complex
    heading: float

    @classmethod
    def of(cls, mover: Seen) -> Motion:
        """Return the current state of a player."""
        return cls(complex(mover.x, mover.y), complex(mover.vx, mover.vy), mover.heading)

    def copy(self) -> Motion:
        """Return a copy."""
        return Motion(self.position, self.velocity, self.heading)


class Predictor:
    """Predicts motion with given mechanics, without noise.

    Attributes:
        farthest: m covered from rest by a number of full dashes.
        ball_sums: m covered by a rolling ball in a number of cycles, per speed.
    """

    def __init__(self, parameters: KeepawayParameters) -> None:
        self.parameters = p = parameters
        self.kickable = p.kickable
        self.contact = p.contact
        self._laterals = [(far, ratio * self.kickable) for far, ratio in LATERAL_FAR]
        self._rolls_out = 1.0 / (1.0 - p.player_decay)
        self._sums = [0.0]  # of the powers of the decay
        for cycle in range(ROLLING):
            self._sums.append(self._sums[-1] + p.player_decay**cycle)
        self._first = [1.0]  # fraction of a distance covered in the first of n cycles
        for cycles in range(1, 101):
            self._first.append((1.0 - p.player_decay) / (1.0 - p.player_decay**cycles))
        self.farthest = [0.0]
        speed = 0.0
        for _ in range(100):
            speed = speed * p.player_decay + FULL * p.dash_rate
            self.farthest.append(self.farthest[-1] + speed)
        self.ball_sums = [0.0]
        for cycle in range(101):
            self.ball_sums.append(self.ball_sums[-1] + p.ball_decay**cycle)

    def ball_after(self, ball: Seen, cycles: int) -> complex:
        """Return the ball's position after some cycles without a kick."""
        rolled = self.ball_sums[min(cycles, 100)]
        return complex(ball.x + ball.vx * rolled, ball.y + ball.vy * rolled)

    def rolled_out(self, motion: Motion, cycles: int) -> complex:
        """Return the position of a player that does nothing for up to four cycles."""
        return motion.position + motion.velocity * self._sums[min(cycles, ROLLING)]

    def dashed(self, motion: Motion, power: float) -> None:
        """Change ``motion`` to what it will be after a dash."""
        p = self.parameters
        velocity = motion.velocity
        if power:
            velocity += cmath.rect(power * p.dash_rate, motion.heading)
        speed = abs(velocity)
        if speed > p.player_speed_max:
            velocity *= p.player_speed_max / speed
        motion.position += velocity
        motion.velocity = velocity * p.player_decay

    def turned(self, motion: Motion, moment: float) -> None:
        """Change ``motion`` to what it will be after a turn."""
        slowed = 1.0 + self.parameters.inertia * abs(motion.velocity)
        motion.heading = wrapped(motion.heading + moment / slowed)
        self.dashed(motion, 0.0)

    def after(self, motion: Motion, order: Order) -> Motion:
        """Return ``motion`` after a command."""
        result = motion.copy()
        if order[0] == "turn":
            self.turned(result, order[1])
        else:
            self.dashed(result, order[1] if order[0] == "dash" else 0.0)
        return result

    def moment(self, angle: float, speed: float) -> float:
        """Return the moment that turns by ``angle``, or as far as one turn goes."""
        moment = angle * (1.0 + self.parameters.inertia * speed)
        return min(max(moment, -PI), PI)

    def turn_to(self, motion: Motion, target: complex, cycles: int = 1) -> Order:
        """Return the turn towards a point, seen from where the player rolls to."""
        off = bearing(motion, target - self.rolled_out(motion, cycles))
        return "turn", self.moment(off, abs(motion.velocity)), 0.0

    def dash_to(self, motion: Motion, target: complex, cycles: int = 1) -> Order:
        """Return the dash, possibly backwards, that covers the distance in this many cycles."""
        p = self.parameters
        ahead = cmath.rect(1.0, -motion.heading)
        way = ((target - motion.position) * ahead).real
        speed = min(way * self._first[min(max(cycles, 1), 100)], p.player_speed_max)
        power = (speed - (motion.velocity * ahead).real) / p.dash_rate
        return "dash", min(max(power, -FULL), FULL), 0.0

    def move_to(self, motion: Motion, target: complex, cycles: int) -> Order:
        """Return the command, a turn or dash, that moves a player to a point in some cycles."""
        turn = self._turn_towards(motion, target, cycles)
        return turn if turn is not None else self.dash_to(motion, target, cycles)

    def moved_to(self, motion: Motion, target: complex, cycles: int) -> Motion:
        """Return ``motion`` after some cycles of moving to a point."""
        result = motion.copy()
        for left in range(cycles, 0, -1):
            kind, amount, _ = self.move_to(result, target, left)
            if kind == "turn":
                self.turned(result, amount)
            else:
                self.dashed(result, amount)
        return result

    def missed_by(self, motion: Motion, target: complex, cycles: int, within: float) -> float:
        """Return how far a player is from a point after some cycles of moving to it, m.

        To the bit, this is the distance of what `moved_to` returns; or infinity if that cannot be
        less than ``within``. Takers spend most of their time here, so all is in one loop, and an
        angle is only computed where the product of two vectors does not tell as much.
        """
        p = self.parameters
        decay, rate, inertia, fastest = p.player_decay, p.dash_rate, p.inertia, p.player_speed_max
        sums, firsts, farthest, rolls_out = self._sums, self._first, self.farthest, self._rolls_out
        (farther, widest), (far, wide) = self._laterals
        near = LATERAL * self.kickable
        position, velocity, heading = motion.position, motion.velocity, motion.heading
        ahead = cmath.rect(1.0, -heading)
        within += ROUNDING
        for left in range(cycles, 0, -1):
            gap = target - position
            apart, speed = abs(gap), abs(velocity)
            if apart > speed * rolls_out + farthest[left if left < 100 else 100] + within:
                return math.inf
            way = target - (position + velocity * sums[left if left < ROLLING else ROLLING])
            aside = way * ahead
            lateral, behind = abs(aside.imag), abs(way) > BEHIND
            turns = lateral > (near if apart <= far else wide if apart <= farther else widest)
            if behind and not turns and aside.real < ROUNDING:
                turns = aside.real < -ROUNDING or abs(_off(way, heading)) > PI / 2.0
            if turns:
                off = _off(way, heading)
                if left < ROLLING and not behind:
                    now = Motion(position, velocity, heading)
                    moment = self._last_moment(now, way, off, _allowed(apart) * self.kickable)
                else:
                    moment = self.moment(off, speed)
                heading = wrapped(heading + moment / (1.0 + inertia * speed))
                ahead = cmath.rect(1.0, -heading)
            else:
                along = (gap * ahead).real * firsts[left if left < 100 else 100]
                if along > fastest:
                    along = fastest
                power = (along - (velocity * ahead).real) / rate
                power = FULL if power > FULL else -FULL if power < -FULL else power
                if power:
                    velocity += cmath.rect(power * rate, heading)
                    speed = abs(velocity)
            if speed > fastest:
                velocity *= fastest / speed
            position += velocity
            velocity *= decay
        return abs(position - target)

    def rolls(self, motion: Motion) -> float:
        """Return how far a player rolls if it does nothing, m."""
        return abs(motion.velocity) / (1.0 - self.parameters.player_decay)

    def _turn_towards(self, motion: Motion, target: complex, cycles: int) -> Order | None:
        """Return the turn needed, or None if the path leads close enough without one."""
        way = target - self.rolled_out(motion, cycles)
        lateral = abs((way * cmath.rect(1.0, -motion.heading)).imag)
        behind = abs(way) > BEHIND
        allowed = _allowed(abs(motion.position - target)) * self.kickable
        off = bearing(motion, way)
        if not (lateral > allowed or (behind and abs(off) > PI / 2.0)):
            return None
        if cycles < ROLLING and not behind:
            return "turn", self._last_moment(motion, way, off, allowed), 0.0
        return "turn", self.moment(off, abs(motion.velocity)), 0.0

    def _last_moment(self, motion: Motion, way: complex, off: float, allowed: float) -> float:
        """Return the moment of a turn near a point: backwards to it, if that saves turns.

        Args:
            motion: of the player.
            way: to the point.
            off: its direction relative to the heading.
            allowed: by how much the path may pass the point, m.
        """
        turning, left, turns = motion.copy(), off, 0
        lateral = math.inf
        while turns < TURNS_MAX and lateral > allowed:
            self.turned(turning, self.moment(left, abs(turning.velocity)))
            lateral = abs((way * cmath.rect(1.0, -turning.heading)).imag)
            left = bearing(turning, way)
            turns += 1
        if turns > 1 and lateral < LATERAL * self.kickable:
            off = wrapped(off + PI)
        return self.moment(off, abs(motion.velocity))


def bearing(motion: Motion, way: complex) -> float:
    """Return the direction of ``way`` relative to the player's heading."""
    return _off(way, motion.heading)


def _off(way: complex, heading: float) -> float:
    return wrapped(cmath.phase(way) - heading)


def _allowed(apart: float) -> float:
    """Return by how much a path may pass a point this far away, in kicking ranges."""
    return next((ratio for far, ratio in LATERAL_FAR if apart > far), LATERAL)


def as_sent(order: Order) -> Order:
    """Return a command as these players send it: rounded to whole power and degrees."""
    kind, amount, direction = order
    if kind == "turn":
        return kind, math.radians(math.trunc(math.degrees(amount))), 0.0
    return kind, float(math.trunc(amount)), math.radians(math.trunc(math.degrees(direction)))
