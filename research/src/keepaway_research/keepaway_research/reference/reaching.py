"""How soon each player can reach the ball, and which is the fastest."""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence

from keepaway_research.reference.prediction import FULL, Motion, Predictor
from keepaway_research.reference.view import Seen, View
from keepaway_world.game.angles import wrapped

HORIZON = 30  # cycles to look ahead
NEVER = 100
STOPPING_OFF = math.radians(20.0)  # a player that is off by more dashes backwards to stop and turn
RESTING = 0.01  # m/cycle


class Reach:
    """One player's estimates about itself and the others in one cycle."""

    def __init__(self, predictor: Predictor, view: View) -> None:
        self._predictor = predictor
        self._me = view.me
        self._ball = view.ball

    def cycles_to(self, player: Seen, target: complex) -> int:
        """Return the number of cycles until a player can have a point within kicking range."""
        predictor, kickable = self._predictor, self._predictor.kickable
        motion = Motion.of(player)
        if abs(target - motion.position) < kickable:
            return 0
        wanted = cmath.phase(target - motion.position)
        cycles = 0
        order = predictor.move_to(motion, target, 1)
        while order[0] == "turn" or (
            order[1] < 0.0 and abs(wrapped(motion.heading - wanted)) > STOPPING_OFF
        ):
            cycles += 1
            motion = predictor.after(motion, order)
            if abs(target - motion.position) < kickable:
                return cycles
            if cycles >= NEVER:
                return NEVER
            order = predictor.move_to(motion, target, 1)
        if player is not self._me:
            forward = (motion.velocity * cmath.rect(1.0, -motion.heading)).real
            return cycles + self._cycles_for(abs(motion.position - target), forward)
        while abs(motion.position - target) > kickable and cycles < NEVER:
            motion = predictor.after(motion, predictor.move_to(motion, target, 1))
            cycles += 1
        return cycles

    def _cycles_for(self, distance: float, speed: float) -> int:
        """Return the number of full dashes that cover a distance."""
        p, kickable = self._predictor.parameters, self._predictor.kickable
        before, cycles = -1.0, 0
        while (
            distance > kickable
            and (abs(speed - before) > 1e-4 or speed < 0.3)
            and cycles < HORIZON + 10
        ):
            before = speed
            speed = min(speed + FULL * p.dash_rate, p.player_speed_max)
            distance = max(0.0, distance - speed)
            speed *= p.player_decay
            cycles += 1
        if distance > kickable:
            cycles += math.ceil((distance - kickable) * p.player_decay / speed)
        return cycles

    def fastest(self, team: Sequence[Seen], others: Sequence[Seen]) -> Seen:
        """Return the player of a team that can reach the ball first.

        If one of the others is faster, it is the player that is first at that place.
        """
        ball = self._ball
        found = team[0]
        for cycles in range(HORIZON + 1):
            place = self._predictor.ball_after(ball, cycles)
            mine, least = self._first_at(team, place, cycles)
            found = mine or found
            if least <= cycles:
                return found
            if self._first_at(others, place, cycles)[1] <= cycles:
                return self._fastest_to(team, place) or found
        return found

    def _first_at(
        self, players: Sequence[Seen], place: complex, cycles: int
    ) -> tuple[Seen | None, int]:
        found, least = None, NEVER
        reach = (cycles + 1) * self._predictor.parameters.player_speed_max
        for player in players:
            if math.hypot(player.x - place.real, player.y - place.imag) < reach:
                needed = self.cycles_to(player, place)
                if needed < least:
                    found, least = player, needed
        return found, least

    def _fastest_to(self, players: Sequence[Seen], place: complex) -> Seen | None:
        found, least = None, NEVER
        speed = self._predictor.parameters.player_speed_max
        for player in players:
            if math.hypot(player.x - place.real, player.y - place.imag) / speed < least:
                needed = self.cycles_to(player, place)
                if needed < least:
                    found, least = player, needed
        return found

    def cycles_to_ball(self, player: Seen) -> int:
        """Return the expected number of cycles until a player reaches the rolling ball."""
        ball, predictor = self._ball, self._predictor
        if math.hypot(ball.vx, ball.vy) < RESTING:
            return self.cycles_to(player, complex(ball.x, ball.y))
        cycles, needed = 0, NEVER
        position = complex(player.x, player.y)
        speed = predictor.parameters.player_speed_max
        while cycles <= needed and cycles < HORIZON:
            cycles += 1
            place = predictor.ball_after(ball, cycles)
            if abs(position - place) / speed < cycles + 1:
                needed = self.cycles_to(player, place)
        return needed
