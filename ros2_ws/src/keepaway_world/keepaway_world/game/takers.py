"""The takers: each goes where it can first reach the ball, and holds a ball within its reach.

Modeled on the UT Austin keepaway players (Stone et al.) on the real simulator: the taker closest
to the ball stops it and holds it if it can kick; the others wait if a teammate has it; otherwise
each intercepts. Takers see everything exactly. Speeds are in m/cycle.
"""

from __future__ import annotations

import math

from keepaway_world.action import Order
from keepaway_world.game.angles import wrapped
from keepaway_world.game.interception import FULL, Interceptor, turn_by
from keepaway_world.game.kicking import kick_power
from keepaway_world.game.physics import Mover, Physics
from keepaway_world.parameters import KeepawayParameters


class TakerTeam:
    """Decides for all takers of a world; shared results are computed once per cycle."""

    def __init__(self, physics: Physics) -> None:
        self._physics = physics
        self.parameters = parameters = physics.parameters
        self._interceptor = Interceptor(parameters, parameters.taker_speed)

    def begin(self) -> None:
        """Begin an episode; takers keep no state."""

    def decide(self) -> list[Order]:
        """Return the order of each taker for this cycle; its dash power is already slowed."""
        physics = self._physics
        takers, ball = physics.takers, physics.ball
        if not takers:
            return []
        distances = [math.hypot(t.x - ball.x, t.y - ball.y) for t in takers]
        closest = distances.index(min(distances))
        has_ball = distances[closest] <= self.parameters.kickable
        waiting = has_ball and distances[closest] < min(
            math.hypot(k.x - ball.x, k.y - ball.y) for k in physics.keepers
        )
        orders: list[Order] = []
        track = None
        for number, taker in enumerate(takers):
            if has_ball and number == closest:
                orders.append(stop_ball(self.parameters, taker, ball))
            elif waiting:
                bearing = math.atan2(ball.y - taker.y, ball.x - taker.x)
                orders.append(turn_by(self.parameters, taker, wrapped(bearing - taker.heading)))
            else:
                if track is None:
                    track = self._interceptor.track(ball)
                orders.append(self._interceptor.intercept(taker, track)[1])
        return orders


def stop_ball(p: KeepawayParameters, player: Mover, ball: Mover) -> Order:
    """Return the kick that stops the ball, or slows it down as much as one kick can."""
    dx, dy = ball.x - player.x, ball.y - player.y
    direction = wrapped(math.atan2(dy, dx) - player.heading)
    power = kick_power(p, math.hypot(ball.vx, ball.vy), math.hypot(dx, dy), direction)
    against = math.atan2(-ball.vy, -ball.vx) - player.heading
    return "kick", min(power, FULL), wrapped(against)
