"""UT Austin's takers: two go to meet the ball and hold it once they have it, any others mark."""

from __future__ import annotations

import math

from keepaway_research.reference.ball_handling import BallHandling
from keepaway_research.reference.eyes import Eyes
from keepaway_research.reference.interception import Meeting
from keepaway_research.reference.marking import AT_THE_BALL, mark, most_open
from keepaway_research.reference.prediction import Motion, Predictor, as_sent
from keepaway_research.reference.reaching import Reach
from keepaway_research.reference.view import Seen, View
from keepaway_world.action import Order
from keepaway_world.game.physics import Physics
from keepaway_world.parameters import KeepawayParameters

FORWARD = -1.0  # they play towards -x
HOLD_RATIO = 0.3  # of the kickable margin: distance of a held ball from the body


class ReferenceTaker:
    """Decides for one taker; remembers where it meets the ball."""

    def __init__(self, parameters: KeepawayParameters) -> None:
        self._predictor = Predictor(parameters)
        self.begin()

    def begin(self) -> None:
        """Forget the last episode."""
        self._meeting = Meeting(self._predictor, FORWARD)

    def decide(self, view: View, cycle: int) -> Order:
        """Return the command of a cycle."""
        me, ball, kickable = view.me, view.ball, self._predictor.kickable

        def apart(player: Seen) -> float:
            return math.hypot(player.x - ball.x, player.y - ball.y)

        closest, mine = min(view.takers, key=apart), apart(me)
        if closest is me and mine < kickable:
            handling = BallHandling(self._predictor, me, ball, view.keepers, FORWARD)
            return as_sent(handling.hold(HOLD_RATIO))
        others = len(view.takers) > AT_THE_BALL
        if others and sum(apart(taker) < mine for taker in view.takers) >= AT_THE_BALL:
            passer = Reach(self._predictor, view).fastest(view.keepers, view.takers)
            keeper = most_open(passer, view.keepers, view.takers)
            return as_sent(mark(self._predictor, me, keeper, ball, FORWARD))
        if (
            closest is not me
            and apart(closest) < kickable
            and apart(closest) < min(map(apart, view.keepers))
        ):
            ahead = self._predictor.ball_after(ball, 1)
            return as_sent(self._predictor.turn_to(Motion.of(me), ahead))
        return as_sent(self._meeting.order(me, ball, view.keepers, cycle))


class ReferenceTakers:
    """Decides for all takers of a world; see `keepaway_world.game.players`.

    They see as the game's `sight` says, and do not know that their dashes are slowed down.
    """

    def __init__(self, physics: Physics) -> None:
        parameters = physics.parameters
        self._speed = parameters.taker_speed
        self._takers = [
            (Eyes(physics, taker), ReferenceTaker(parameters)) for taker in physics.takers
        ]
        self._cycle = 0

    def begin(self) -> None:
        """Forget the last episode."""
        self._cycle = 0
        for eyes, taker in self._takers:
            eyes.begin()
            taker.begin()

    def decide(self) -> list[Order]:
        """Return the order of each taker for this cycle; its dash power is already slowed."""
        self._cycle += 1
        orders = []
        for eyes, taker in self._takers:
            order = taker.decide(eyes.view(), self._cycle)
            eyes.did(order)
            kind, amount, direction = order
            orders.append((kind, amount * self._speed if kind == "dash" else amount, direction))
        return orders
