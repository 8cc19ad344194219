"""Meeting a rolling ball: the soonest safe place, and the last two cycles before it."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

from keepaway_research.reference.prediction import Motion, Predictor
from keepaway_research.reference.reaching import HORIZON, NEVER
from keepaway_research.reference.view import Seen
from keepaway_world.action import Order
from keepaway_world.game.angles import PI, wrapped

MORE = 20  # cycles after the first possible one to search for a better place
SAFER = 3  # cycles by which a safer place may be later
SAFE, SAFEST = 0.7, 0.5  # of the kicking range: distance of the ball at a safe place
SAME = 1.0  # m: a place this close to the previous one is the same
ROLLING = 0.6  # m/cycle: below this speed the place matters little
LATER = 2  # cycles by which the previous place may be later
NEAR_BY = 3  # cycles: below this, the last steps matter
THERE = 0.5  # m: no need to move
ASIDE = math.radians(25.0)
PRESSED = 3.0  # m from the player to an opponent
ONE_DASH, ONE_TURN = 0.95, 0.8  # of the kicking range: where the ball must be afterwards
CLOSE = 1.0 / 6.0  # of the kickable margin: wanted distance of the ball from the body


class Meeting:
    """Meets the ball; one instance per player, since it remembers its destination.

    These players prefer to face the opponents' goal when they have the ball, and turn to it when
    there is time.

    Args:
        predictor: of motion.
        forward: 1 for a team that plays towards +x, -1 for one that plays towards -x.
    """

    def __init__(self, predictor: Predictor, forward: float) -> None:
        self._predictor = predictor
        self._forward = forward
        self._facing = 0.0 if forward > 0.0 else PI
        self._place: complex | None = None
        self._cycle = -10

    def order(self, me: Seen, ball: Seen, opponents: Sequence[Seen], cycle: int) -> Order:
        """Return the command of this cycle."""
        predictor = self._predictor
        motion = Motion.of(me)
        if cycle - self._cycle > 2:
            self._place = None
        self._cycle = cycle
        cycles = self._when(motion, ball)
        place = self._place = predictor.ball_after(ball, cycles)
        if cycles < NEAR_BY:
            last_steps = self._last_steps(motion, ball, opponents)
            if last_steps is not None:
                return last_steps
        if abs(predictor.rolled_out(motion, cycles) - place) < THERE:
            return predictor.turn_to(motion, motion.position + self._forward)
        return predictor.move_to(motion, place, cycles)

    def _when(self, motion: Motion, ball: Seen) -> int:
        """Return the number of cycles until meeting the ball: as planned, or else the earliest."""
        predictor, kickable = self._predictor, self._predictor.kickable
        first: int | None = None
        least, nearest = 0, 10.0  # the safest of the soonest cycles
        planned: int | None = None
        planned_off = SAME
        start, velocity = complex(ball.x, ball.y), complex(ball.vx, ball.vy)
        rolled, farthest = predictor.ball_sums, predictor.farthest
        position, rolls = motion.position, predictor.rolls(motion)
        place = start
        for cycles in range(HORIZON + 1):
            before, place = place, start + velocity * rolled[cycles]
            rolling = abs(place - before) if cycles else math.hypot(ball.vx, ball.vy)
            as_planned = rolling > ROLLING and self._place is not None
            safer = first is None or (
                nearest > SAFEST * kickable
                and (
                    cycles <= least + SAFER or (planned is not None and cycles <= planned + SAFER)
                )
            )
            if first is not None and (cycles > first + MORE or not (as_planned or safer)):
                break
            off = abs(place - self._place) if self._place is not None else math.inf
            if not (safer or off < planned_off):
                continue
            if abs(place - position) > rolls + farthest[cycles] + kickable:
                continue
            near = predictor.missed_by(motion, place, cycles, kickable)
            if near >= kickable:
                continue
            if first is None:
                first = least = cycles
            if as_planned and off < planned_off and near < SAFE * kickable:
                planned, planned_off, nearest = cycles, off, near
            elif safer and near < nearest:
                least, nearest = cycles, near
                if planned == least - 1:
                    planned = least
        if first is None:
            return NEVER
        if planned is not None and least <= planned + LATER:
            return planned
        return first

    def _last_steps(self, motion: Motion, ball: Seen, opponents: Sequence[Seen]) -> Order | None:
        """Return the turn or dash after which the ball can be kicked, or None."""
        predictor, kickable = self._predictor, self._predictor.kickable
        p = predictor.parameters
        position = motion.position
        far = 3.0 * p.player_speed_max + (1.0 + p.ball_decay) * p.ball_speed_max + kickable
        if abs(complex(ball.x, ball.y) - position) > far:
            return None
        ball_1, ball_2 = predictor.ball_after(ball, 1), predictor.ball_after(ball, 2)
        dash = self._one_dash(motion, ball_1)
        pressed = any(abs(complex(o.x, o.y) - position) < PRESSED for o in opponents)
        if pressed and dash is not None:
            return dash
        turn = predictor.turn_to(motion, predictor.rolled_out(motion, 1) + self._forward)
        after = predictor.after(motion, turn)
        affordable = False
        for expected in (ball_1, ball_2):
            if expected is ball_2:
                predictor.turned(after, self._moment_to_face(after))
            if abs(after.position - expected) < ONE_TURN * kickable:
                affordable = True
                if abs(self._off(after)) < ASIDE:
                    return turn
        if abs(self._off(motion)) > ASIDE:
            bump = self._bump(motion, ball, ball_1)
            if bump is not None:
                return bump
            halt = predictor.dash_to(motion, position)
            if abs(predictor.after(motion, halt).position - ball_2) < ONE_TURN * kickable:
                return halt
        return turn if affordable else dash

    def _off(self, motion: Motion) -> float:
        """Return how far a player must turn to face the others' goal line."""
        return wrapped(self._facing - motion.heading)

    def _moment_to_face(self, motion: Motion) -> float:
        """Return the moment that turns a player there."""
        return self._predictor.moment(self._off(motion), abs(motion.velocity))

    def _one_dash(self, motion: Motion, ball: complex) -> Order | None:
        """Return the dash that brings the ball within reach, in front of the body if possible."""
        predictor = self._predictor
        p = predictor.parameters
        reach = ONE_DASH * predictor.kickable
        heading = cmath.rect(1.0, motion.heading)
        start = predictor.rolled_out(motion, 1)
        wanted = p.contact + p.kickable_margin * CLOSE
        relative = (ball - start) * heading.conjugate()
        under = wanted * wanted - relative.imag * relative.imag
        if under >= 0.0:
            points = [start + heading * (relative.real + s * math.sqrt(under)) for s in (1, -1)]
            points.sort(key=lambda point: -point.real * self._forward)
            for point in points:
                _, power, _ = predictor.dash_to(motion, point)
                after = predictor.after(motion, ("dash", float(math.trunc(power)), 0.0))
                if abs(after.position - ball) < reach:
                    return "dash", power, 0.0
        dash = predictor.dash_to(motion, ball)
        if abs(predictor.after(motion, dash).position - ball) < reach:
            return dash
        return None

    def _bump(self, motion: Motion, ball: Seen, ball_1: complex) -> Order | None:
        """Return a command after which player and ball collide, which stops both, or None."""
        predictor = self._predictor
        apart = abs(complex(ball.x, ball.y) - motion.position)
        speed = math.hypot(ball.vx, ball.vy)
        if apart > speed + predictor.parameters.player_speed_max:
            return None
        for order in (
            predictor.turn_to(motion, motion.position + self._forward),
            predictor.dash_to(motion, ball_1),
        ):
            if abs(predictor.after(motion, order).position - ball_1) < predictor.contact:
                return order
        return None
