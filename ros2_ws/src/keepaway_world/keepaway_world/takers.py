"""The takers: they go where they can first reach the ball, and hold it when they have it.

Written after the behavior of the UT Austin keepaway players (Stone et al.): the taker closest to
the ball holds it if it can kick; the others wait if a team mate has it; otherwise each
intercepts. Takers see everything exactly. Speeds are in m/cycle.
"""

from __future__ import annotations

import math

from keepaway_world.kicking import kick_power
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.physics import PI, Mover, Physics, wrapped

HORIZON = 30  # cycles that a taker looks ahead
TURN_WHEN_OFF = math.radians(7.0)
TURNS_MAX = 5
HOLD_DISTANCE = 0.6  # m, of the ball from the taker's centre
HOLD_TOLERANCE = 0.3  # m
HOLD_ASIDE = math.radians(45.0)
NEAR = 5.0  # m: a keeper nearer than this is turned away from
FULL = 100.0

Command = tuple[str, float, float]
"""("dash", power, 0), ("turn", moment, 0) or ("kick", power, direction)."""

Point = tuple[float, float]


class TakerTeam:
    """Decides for all takers of a world; what they have in common is worked out once a cycle."""

    def __init__(self, parameters: KeepawayParameters) -> None:
        self.parameters = p = parameters
        planned = p.taker_speed if p.takers_know_speed else 1.0
        self._push = FULL * p.dash_rate * planned
        self._top_speed = min(self._push / (1.0 - p.player_decay), p.player_speed_max)
        self._coasting = 1.0 / (1.0 - p.player_decay)
        # Distance covered from rest by a number of dashes, and what is left of a speed of 1.
        self._dashed = [0.0]
        self._coasted = [0.0]
        speed = left = 0.0
        for cycle in range(HORIZON):
            speed = min(speed * p.player_decay + self._push, p.player_speed_max)
            self._dashed.append(self._dashed[-1] + speed)
            left = p.player_decay**cycle
            self._coasted.append(self._coasted[-1] + left)
        self._rolled = [0.0]
        for cycle in range(HORIZON):
            self._rolled.append(self._rolled[-1] + p.ball_decay**cycle)

    def decide(self, physics: Physics) -> list[Command]:
        """Return the command of each taker for this cycle, its dash power not yet slowed."""
        takers, ball = physics.takers, physics.ball
        distances = [math.hypot(t.x - ball.x, t.y - ball.y) for t in takers]
        if not takers:
            return []
        closest = distances.index(min(distances))
        kickable = self.parameters.kickable
        has_ball = distances[closest] <= kickable
        if has_ball:
            nearest_keeper = min(math.hypot(k.x - ball.x, k.y - ball.y) for k in physics.keepers)
            waiting = distances[closest] < nearest_keeper
        else:
            waiting = False
        commands: list[Command] = []
        track: list[Point] | None = None
        for number, taker in enumerate(takers):
            if has_ball and number == closest:
                commands.append(self._hold(taker, physics))
            elif waiting:
                commands.append(self._turn_to(taker, ball.x, ball.y))
            else:
                if track is None:
                    track = self._ball_track(ball)
                commands.append(self._go_to(taker, *self._interception(taker, track)))
        return commands

    def _ball_track(self, ball: Mover) -> list[Point]:
        """Return where the ball will be after 0, 1, ... cycles if nobody kicks it."""
        x, y, vx, vy = ball.x, ball.y, ball.vx, ball.vy
        return [(x + vx * rolled, y + vy * rolled) for rolled in self._rolled]

    def _interception(self, taker: Mover, track: list[Point]) -> Point:
        """Return the first point of the ball's track that the taker reaches in time."""
        kickable = self.parameters.kickable
        rest_x = taker.x + taker.vx * self._coasting
        rest_y = taker.y + taker.vy * self._coasting
        for cycles in range(1, HORIZON + 1):
            x, y = track[cycles]
            far = math.hypot(x - rest_x, y - rest_y)
            if far - kickable > cycles * self._top_speed:
                continue
            heading, turns = self._turned(taker, math.atan2(y - rest_y, x - rest_x), cycles)
            dashed = self._dashed[cycles - turns]
            coasted = self._coasted[cycles]
            at_x = taker.x + taker.vx * coasted + dashed * math.cos(heading)
            at_y = taker.y + taker.vy * coasted + dashed * math.sin(heading)
            if (
                math.hypot(x - at_x, y - at_y) < kickable
                or math.hypot(at_x - rest_x, at_y - rest_y) > far - kickable
            ):
                return x, y
        return track[HORIZON]

    def _turned(self, taker: Mover, bearing: float, cycles: int) -> tuple[float, int]:
        """Return the heading after as many turns as it takes to face ``bearing``."""
        p = self.parameters
        heading, turns = taker.heading, 0
        speed = math.hypot(taker.vx, taker.vy)
        limit = min(cycles, TURNS_MAX)
        while turns < limit:
            off = wrapped(bearing - heading)
            if abs(off) <= TURN_WHEN_OFF:
                break
            most = PI / (1.0 + p.inertia * speed)
            heading += min(max(off, -most), most)
            speed *= p.player_decay
            turns += 1
        return heading, turns

    def _go_to(self, taker: Mover, x: float, y: float) -> Command:
        """Turn towards a point, seen from where the taker comes to rest, or dash to it."""
        rest_x = taker.x + taker.vx * self._coasting
        rest_y = taker.y + taker.vy * self._coasting
        off = wrapped(math.atan2(y - rest_y, x - rest_x) - taker.heading)
        if abs(off) > TURN_WHEN_OFF:
            return self._turn_by(taker, off)
        distance = math.hypot(x - taker.x, y - taker.y)
        forward = taker.vx * math.cos(taker.heading) + taker.vy * math.sin(taker.heading)
        power = (distance - forward) / self.parameters.dash_rate
        return "dash", min(max(power, 0.0), FULL), 0.0

    def _turn_to(self, taker: Mover, x: float, y: float) -> Command:
        return self._turn_by(
            taker, wrapped(math.atan2(y - taker.y, x - taker.x) - taker.heading)
        )

    def _turn_by(self, taker: Mover, angle: float) -> Command:
        speed = math.hypot(taker.vx, taker.vy)
        moment = angle * (1.0 + self.parameters.inertia * speed)
        return "turn", min(max(moment, -PI), PI), 0.0

    def _hold(self, taker: Mover, physics: Physics) -> Command:
        """Keep the ball close, on the side away from a keeper that is near."""
        p, ball = self.parameters, physics.ball
        bearing = taker.heading
        nearest = min(
            physics.keepers, key=lambda keeper: math.hypot(keeper.x - ball.x, keeper.y - ball.y)
        )
        if math.hypot(nearest.x - ball.x, nearest.y - ball.y) < NEAR:
            away = math.atan2(taker.y - nearest.y, taker.x - nearest.x)
            left = wrapped(nearest.heading - away) <= 0.0
            bearing = away + (HOLD_ASIDE if left else -HOLD_ASIDE)
        next_x, next_y = taker.x + taker.vx, taker.y + taker.vy
        aim_x = next_x + HOLD_DISTANCE * math.cos(bearing)
        aim_y = next_y + HOLD_DISTANCE * math.sin(bearing)
        rolling_x, rolling_y = ball.x + ball.vx, ball.y + ball.vy
        if math.hypot(rolling_x - aim_x, rolling_y - aim_y) < HOLD_TOLERANCE:
            return self._turn_to(taker, ball.x, ball.y)
        power, direction = _kick(p, taker, ball, aim_x - rolling_x, aim_y - rolling_y)
        if power > FULL:  # too fast to be moved there at once: stop it first
            power, direction = _kick(p, taker, ball, -ball.vx, -ball.vy)
        return "kick", min(power, FULL), direction


def _kick(
    p: KeepawayParameters, taker: Mover, ball: Mover, ax: float, ay: float
) -> tuple[float, float]:
    """Return power and direction of the kick that accelerates the ball by (ax, ay) m/cycle²."""
    dx, dy = ball.x - taker.x, ball.y - taker.y
    distance, direction = math.hypot(dx, dy), wrapped(math.atan2(dy, dx) - taker.heading)
    return (
        kick_power(p, math.hypot(ax, ay), distance, direction),
        wrapped(math.atan2(ay, ax) - taker.heading),
    )
