"""Kicks: passing in one step or several, stopping the ball, holding it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

from keepaway_research.reference.prediction import FULL, Motion, Predictor
from keepaway_research.reference.view import Seen
from keepaway_world.action import Order
from keepaway_world.game.angles import PI, wrapped
from keepaway_world.game.kicking import pass_speed

SAFE_STOP = 0.8  # of the kicking range: a ball may stop within this
SAFE_TURN = 0.85  # likewise, for a player that turns while holding
PULLED_IN = 0.7  # likewise, where a ball that would roll away is put
IN_PLACE = 0.3  # m: a held ball this close to its place is left alone
CLOSE = 0.16  # of the kickable margin: where a ball is put to be kicked well
FULL_KICK = 1.05  # of the available power: a kick that needs more is made in two steps
PRESSED_KICK = 1.3  # likewise with an opponent within PRESSED of the ball
PRESSED = 2.0  # m
SHIELDING = 5.0  # m: the ball is shielded from an opponent nearer than this
SHIELD_ANGLE = math.radians(45.0)
GOAL = 52.5  # m: distance of the goal that a player holding the ball turns to


class BallHandling:
    """What one player can do in this cycle with a kickable ball.

    Args:
        predictor: of motion.
        me, ball: their current states.
        opponents: the other team.
        forward: 1 for a team that plays towards +x, -1 for one that plays towards -x.
    """

    def __init__(
        self,
        predictor: Predictor,
        me: Seen,
        ball: Seen,
        opponents: Sequence[Seen],
        forward: float,
    ) -> None:
        self._forward = forward
        self._predictor = predictor
        self._motion = Motion.of(me)
        self._next = predictor.rolled_out(self._motion, 1)
        self._ball = complex(ball.x, ball.y)
        self._velocity = complex(ball.vx, ball.vy)
        self._opponent = min(
            opponents, key=lambda o: abs(complex(o.x, o.y) - self._ball), default=None
        )
        p = predictor.parameters
        to_ball = self._ball - self._motion.position
        aside = abs(wrapped(cmath.phase(to_ball) - me.heading)) if to_ball else 0.0
        away = (abs(to_ball) - p.contact) / p.kickable_margin
        self._rate = p.kick_rate * (1.0 - 0.25 * aside / PI - 0.25 * away)

    def _kick(self, acceleration: complex, power: float | None = None) -> Order:
        direction = wrapped(cmath.phase(acceleration) - self._motion.heading)
        if power is None:
            power = abs(acceleration) / self._rate
        return "kick", min(power, FULL), direction

    def _distance_of_opponent(self) -> float:
        if self._opponent is None:
            return math.inf
        return abs(complex(self._opponent.x, self._opponent.y) - self._ball)

    def pass_to(self, target: complex) -> Order:
        """Return the kick that passes the ball, or that prepares it for a pass."""
        p = self._predictor.parameters
        way = target - self._ball
        wanted = cmath.rect(pass_speed(p, abs(way)), cmath.phase(way))
        if abs(self._next - self._ball - wanted) < p.contact:
            wanted = self._around_the_body(wanted)
        power = abs(wanted - self._velocity) / self._rate
        pressed = self._distance_of_opponent() < PRESSED and power <= PRESSED_KICK * FULL
        if power <= FULL_KICK * FULL or pressed:
            return self._accelerate_to(wanted)
        return self._put_at(0.0, CLOSE)

    def _around_the_body(self, wanted: complex) -> complex:
        """Return a velocity in the same direction at which the ball misses the passer."""
        contact = self._predictor.contact
        direction = wanted / abs(wanted)
        passing = abs(((self._motion.position - self._ball) * direction.conjugate()).real)
        speed = passing - contact if abs(wanted) < passing else passing + contact
        return direction * speed

    def _accelerate_to(self, wanted: complex) -> Order:
        acceleration = wanted - self._velocity
        if (
            abs(acceleration) < self._predictor.parameters.ball_acceleration_max
            and abs(acceleration) <= self._rate * FULL
        ):
            return self._kick(acceleration)
        direction = cmath.phase(wanted)
        aside = (self._velocity * cmath.rect(1.0, -direction)).imag
        correction = math.asin(min(max(aside / (self._rate * FULL), -1.0), 1.0))
        return self._kick(cmath.rect(1.0, direction - correction), FULL)

    def stop(self) -> Order:
        """Return the kick that stops the ball, or keeps it within reach of a moving player."""
        power = min(abs(self._velocity) / self._rate, FULL)
        order = self._kick(-self._velocity, power)
        _, power, direction = order
        sent = math.radians(math.trunc(math.degrees(direction))) + self._motion.heading
        expected = self._ball + self._velocity + cmath.rect(self._rate * math.trunc(power), sent)
        kickable = self._predictor.kickable
        if abs(expected - self._next) < SAFE_STOP * kickable:
            return order
        apart = self._ball - self._next
        place = self._next + cmath.rect(
            min(PULLED_IN * kickable, abs(apart) - 0.1), cmath.phase(apart)
        )
        return self._accelerate_to(place - self._ball)

    def _put_at(self, direction: float, ratio: float) -> Order:
        """Return the kick that brings the ball to a place beside the player, or stops it.

        Args:
            direction: of the place, relative to the body.
            ratio: distance from the body, as a fraction of the kickable margin.
        """
        p = self._predictor.parameters
        place = self._next + cmath.rect(
            p.contact + p.kickable_margin * ratio, self._motion.heading + direction
        )
        acceleration = place - self._ball - self._velocity
        if abs(acceleration) / self._rate > FULL and abs(self._velocity) > 0.1:
            return self.stop()
        return self._kick(acceleration)

    def hold(self, ratio: float) -> Order:
        """Return the kick that keeps the ball away from the nearest opponent, or a turn.

        With an opponent near by, the ball's place is on the far side of the player, 45 degrees to
        the side away from the opponent's heading. These players judge whether the ball is in its
        place as if they faced the goal, whatever their heading.
        """
        direction = 0.0
        opponent = self._opponent
        if opponent is not None and self._distance_of_opponent() < SHIELDING:
            away = cmath.phase(self._motion.position - complex(opponent.x, opponent.y))
            side = -1.0 if wrapped(opponent.heading - away) > 0.0 else 1.0
            direction = wrapped(away + side * SHIELD_ANGLE - self._motion.heading)
        in_place = self._motion.position + self._forward * cmath.rect(ratio, direction)
        if abs(self._ball - in_place) < IN_PLACE:
            turn = self._predictor.turn_to(self._motion, complex(self._forward * GOAL, 0.0))
            expected = self._predictor.after(self._motion, turn).position
            if abs(expected - self._ball - self._velocity) < SAFE_TURN * self._predictor.kickable:
                return turn
        return self._put_at(direction, ratio)
