"""UT Austin's takers: each meets the ball by its own prediction, and holds it when it has it."""

from __future__ import annotations

import math

from keepaway_world.interception import Order
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.physics import Mover, Physics
from keepaway_world.reference.ball_handling import BallHandling
from keepaway_world.reference.interception import Meeting
from keepaway_world.reference.prediction import Motion, Predictor, as_sent

FORWARD = -1.0  # they play towards -x
HOLD_RATIO = 0.3  # of the kickable margin: how far from the body a held ball is kept


class ReferenceTakers:
    """Decides for all takers of a world, as `keepaway_world.takers.TakerTeam` does.

    They do not know that their dashes are slowed down, and do not mark when there are many.
    """

    def __init__(self, parameters: KeepawayParameters) -> None:
        self._speed = parameters.taker_speed
        self._predictor = Predictor(parameters)
        self._cycle = 0
        self._meetings: dict[str, Meeting] = {}
        self.begin()

    def begin(self) -> None:
        """Forget the last episode."""
        self._cycle = 0
        self._meetings.clear()

    def decide(self, physics: Physics) -> list[Order]:
        """Return the order of each taker for this cycle; its dash power is already slowed."""
        ball, takers = physics.ball, physics.takers
        self._cycle += 1
        if not takers:
            return []

        def apart(player: Mover) -> float:
            return math.hypot(player.x - ball.x, player.y - ball.y)

        closest = min(takers, key=apart)
        has_ball = apart(closest) < self._predictor.kickable
        waiting = has_ball and apart(closest) < min(map(apart, physics.keepers))
        orders = []
        for taker in takers:
            if has_ball and taker is closest:
                handling = BallHandling(self._predictor, taker, ball, physics.keepers, FORWARD)
                order = handling.hold(HOLD_RATIO)
            elif waiting:
                order = self._predictor.turn_to(
                    Motion.of(taker), self._predictor.ball_after(ball, 1)
                )
            else:
                meeting = self._meetings.setdefault(taker.name, Meeting(self._predictor, FORWARD))
                order = meeting.order(taker, ball, physics.keepers, self._cycle)
            kind, amount, direction = as_sent(order)
            orders.append((kind, amount * self._speed if kind == "dash" else amount, direction))
        return orders
