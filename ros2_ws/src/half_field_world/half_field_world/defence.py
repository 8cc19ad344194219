"""The opponents of half-field attack: defenders and a goalie, who see everything exactly.

The defender nearest in time goes to the ball and holds it; each other defender stands between the
goal and an attacker without the ball, the most advanced attacker first. The goalie catches, comes
out for a shot and for a ball that no attacker reaches earlier, and otherwise stands on the line
from the ball to the middle of the goal. Do not change this policy: published results of attackers
depend on it.
"""

from __future__ import annotations

import math
from itertools import pairwise

from half_field_world import field
from keepaway_world.action import Order
from keepaway_world.game.angles import wrapped
from keepaway_world.game.interception import (
    ALIGNED,
    FULL,
    HORIZON,
    Interceptor,
    Point,
    power_to_rest,
    turn_by,
)
from keepaway_world.game.physics import Mover, Physics
from keepaway_world.game.takers import stop_ball

MARKING = 1.5  # m: distance from a marked attacker, towards the goal
ARRIVED = 0.5  # m
OUT_OF_GOAL, OUT_MOST = 0.15, 4.0  # how far the goalie comes out: of the ball's distance; m


class Defence:
    """Decides for all defenders and the goalie of a world."""

    def __init__(self, physics: Physics) -> None:
        self._physics = physics
        self._p = p = physics.parameters
        self._own = Interceptor(p, p.taker_speed)
        self._attackers = Interceptor(p)

    def begin(self) -> None:
        """Do nothing: the defenders have no state."""

    def decide(self) -> list[Order]:
        """Return the order of each opponent for this cycle, with the dash power already slowed."""
        physics, ball = self._physics, self._physics.ball
        track = self._own.track(ball)
        *defenders, goalie = physics.takers
        attack = min(self._attackers.intercept(a, track)[0] for a in physics.keepers)
        plans = [self._own.intercept(d, track) for d in defenders]
        orders: list[Order] = []
        if defenders:
            chaser = min(
                range(len(defenders)), key=lambda i: (plans[i][0], _apart(defenders[i], ball))
            )
            marked = self._to_mark(ball)
            for number, defender in enumerate(defenders):
                if number != chaser:
                    mate = marked.pop(0) if marked else ball
                    orders.append(self._mark(defender, mate))
                elif _apart(defender, ball) <= self._p.kickable:
                    orders.append(stop_ball(self._p, defender, ball))
                else:
                    orders.append(plans[number][1])
        return [*orders, self._keep_goal(goalie, track, attack)]

    def _to_mark(self, ball: Mover) -> list[Mover]:
        """Return all attackers except the one nearest to the ball, ordered by nearness to goal."""
        nearest = min(self._physics.keepers, key=lambda a: _apart(a, ball))
        others = [a for a in self._physics.keepers if a is not nearest]
        return sorted(others, key=lambda a: math.hypot(field.GOAL_X - a.x, a.y))

    def _mark(self, defender: Mover, mate: Mover) -> Order:
        dx, dy = field.GOAL_X - mate.x, -mate.y
        part = MARKING / max(math.hypot(dx, dy), MARKING)
        return self._go(defender, mate.x + dx * part, mate.y + dy * part)

    def _keep_goal(self, goalie: Mover, track: list[Point], attack: int) -> Order:
        ball = self._physics.ball
        away = _apart(goalie, ball)
        if away <= field.CATCHABLE and field.in_area(ball.x, ball.y):
            bearing = math.atan2(ball.y - goalie.y, ball.x - goalie.x)
            return "catch", wrapped(bearing - goalie.heading), 0.0
        if away <= self._p.kickable:
            return stop_ball(self._p, goalie, ball)
        cycles, order = self._own.intercept(goalie, track)
        x, y = track[min(cycles, HORIZON)]
        if _scores(track) or (cycles < attack and field.in_area(x, y)):
            return order
        dx, dy = ball.x - field.GOAL_X, ball.y
        far = math.hypot(dx, dy)
        part = min(OUT_OF_GOAL * far, OUT_MOST) / far
        return self._go(goalie, field.GOAL_X + dx * part, dy * part)

    def _go(self, player: Mover, x: float, y: float) -> Order:
        """Return the order to come to rest at a place, and then to face the ball."""
        p, ball = self._p, self._physics.ball
        dx, dy = x - player.x, y - player.y
        far = math.hypot(dx, dy)
        there = far < ARRIVED
        aim = (ball.x - player.x, ball.y - player.y) if there else (dx, dy)
        off = wrapped(math.atan2(aim[1], aim[0]) - player.heading)
        if abs(off) > ALIGNED:
            return turn_by(p, player, off)
        if there:
            return "none", 0.0, 0.0
        ahead = player.vx * math.cos(player.heading) + player.vy * math.sin(player.heading)
        return "dash", power_to_rest(p, far, ahead, FULL * p.taker_speed), 0.0


def _scores(track: list[Point]) -> bool:
    """Whether the ball rolls into the goal."""
    for (x, y), (next_x, next_y) in pairwise(track):
        if x <= field.GOAL_X < next_x:
            at_line = y + (next_y - y) * (field.GOAL_X - x) / (next_x - x)
            return abs(at_line) < field.GOAL_WIDTH / 2.0
    return False


def _apart(a: Mover, b: Mover) -> float:
    return math.hypot(a.x - b.x, a.y - b.y)
