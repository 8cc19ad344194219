"""The ball and the players as bodies that move and collide as in rcssserver.

One cycle runs in the simulator's order: commands, acceleration, velocity, noise, position, decay,
collisions. pymunk integrates the positions and finds overlapping bodies. These follow rcssserver's
rule (they are moved apart, and their velocities multiplied by -0.1) instead of pymunk's impulses.

Inside the world speeds are in meters per cycle of 0.1 s, accelerations in meters per cycle²,
x points right, y up, angles are counter-clockwise radians.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from random import Random
from typing import Any

import pymunk

from keepaway_world.game.angles import PI, wrapped
from keepaway_world.game.kicking import off_place
from keepaway_world.parameters import KeepawayParameters

BALL_CATEGORY = 1
PLAYER_CATEGORY = 2
COLLISION_ROUNDS = 10  # rcssserver gives up separating bodies after this many
REBOUND = -0.1
SEPARATION = 1e-10  # rcssserver's EPS: separated bodies no longer touch


Names = tuple[Sequence[str], Sequence[str]]


class Mover:
    """The ball or a player.

    Attributes:
        name, kind: the body's name and kind; the kind is such as "ball", "keeper" or "taker".
        x, y: center, m.  heading: direction of the body, rad; a ball has none.
        vx, vy: velocity after decay, m/cycle.
        ax, ay: acceleration from this cycle's commands, m/cycle².
    """

    def __init__(self, name: str, kind: str, index: int, p: KeepawayParameters) -> None:
        ball = kind == "ball"
        self.name, self.kind, self.index = name, kind, index
        self.x = self.y = self.heading = 0.0
        self.vx = self.vy = self.ax = self.ay = 0.0
        self.radius = p.ball_radius if ball else p.player_radius
        self.decay = p.ball_decay if ball else p.player_decay
        self.speed_max = p.ball_speed_max if ball else p.player_speed_max
        self.acceleration_max = p.ball_acceleration_max if ball else p.player_acceleration_max
        self.rand = (p.ball_rand if ball else p.player_rand) * p.movement_noise
        self.body = pymunk.Body(1.0, math.inf)
        self.shape = pymunk.Circle(self.body, self.radius)
        self.shape.sensor = True  # pymunk reports overlaps but never pushes it
        collides_with = PLAYER_CATEGORY if (p.ball_collides if ball else p.players_collide) else 0
        if not ball and p.ball_collides:
            collides_with |= BALL_CATEGORY
        self.shape.filter = pymunk.ShapeFilter(
            categories=BALL_CATEGORY if ball else PLAYER_CATEGORY, mask=collides_with
        )


class Physics:
    """All bodies of one world, and the commands that accelerate them.

    Args:
        parameters: mechanics, counts of players, noise.
        random: source of all noise; the same draws give the same motion.
        names: names of the keepers and the takers, as many as in the parameters. The part before
            the first "_" is the kind.
    """

    def __init__(
        self, parameters: KeepawayParameters, random: Random, names: Names | None = None
    ) -> None:
        self.parameters = p = parameters
        self.random = random
        self.ball = Mover("ball", "ball", 0, p)
        keepers, takers = names or (
            [f"keeper_{i + 1}" for i in range(p.keepers)],
            [f"taker_{i + 1}" for i in range(p.takers)],
        )
        players = [
            Mover(name, name.partition("_")[0], i + 1, p)
            for i, name in enumerate((*keepers, *takers))
        ]
        self.keepers, self.takers = players[: p.keepers], players[p.keepers :]
        self.players = [*self.keepers, *self.takers]
        self.movers = [self.ball, *self.players]
        self._space = pymunk.Space()
        self._space.iterations = 1
        self._touching: list[tuple[pymunk.Shape, ...]] = []
        self._by_shape: dict[pymunk.Shape, Mover] = {m.shape: m for m in self.movers}
        for mover in self.movers:
            self._space.add(mover.body, mover.shape)
        if p.ball_collides or p.players_collide:
            self._space.on_collision(pre_solve=self._touch)

    def _touch(self, arbiter: pymunk.Arbiter, space: pymunk.Space, data: Any) -> None:
        self._touching.append(arbiter.shapes)

    def put(
        self,
        mover: Mover,
        x: float,
        y: float,
        heading: float = 0.0,
        vx: float = 0.0,
        vy: float = 0.0,
    ) -> None:
        """Put a body somewhere; speeds in m/cycle."""
        mover.x, mover.y, mover.heading, mover.vx, mover.vy = x, y, heading, vx, vy
        mover.ax = mover.ay = 0.0
        mover.body.position = x, y
        self._space.reindex_shapes_for_body(mover.body)

    # Commands: at most one per cycle and player, before `advance`.

    def dash(self, player: Mover, power: float) -> None:
        """Accelerate along the body; ``power`` from -100 to 100, clipped as the server does."""
        acceleration = min(max(power, -100.0), 100.0) * self.parameters.dash_rate
        player.ax += acceleration * math.cos(player.heading)
        player.ay += acceleration * math.sin(player.heading)

    def turn(self, player: Mover, moment: float) -> None:
        """Turn by ``moment`` rad (-pi to pi, clipped); less at higher speed."""
        p = self.parameters
        moment = min(max(moment, -PI), PI)
        if p.turn_noise:
            moment *= 1.0 + p.turn_noise * p.player_rand * (2.0 * self.random.random() - 1.0)
        turned = moment / (1.0 + p.inertia * math.hypot(player.vx, player.vy))
        player.heading = wrapped(player.heading + turned)

    def kick(self, player: Mover, power: float, direction: float) -> bool:
        """Accelerate the ball, if it is kickable.

        Args:
            player: the kicker.
            power: 0 to 100, clipped.
            direction: relative to the body, rad.

        Returns:
            Whether the ball was kicked.
        """
        p, ball = self.parameters, self.ball
        dx, dy = ball.x - player.x, ball.y - player.y
        distance = math.hypot(dx, dy)
        if distance > p.kickable:
            return False
        power = min(max(power, 0.0), 100.0)
        aside = wrapped(math.atan2(dy, dx) - player.heading) if distance else 0.0
        off = off_place(p, distance, aside)
        acceleration = power * p.kick_rate * (1.0 - off)
        angle = player.heading + min(max(direction, -PI), PI)
        ball.ax += acceleration * math.cos(angle)
        ball.ay += acceleration * math.sin(angle)
        if p.kick_noise:
            speed = math.hypot(ball.vx, ball.vy)
            position_rate = 0.5 + off
            speed_rate = 0.5 + 0.5 * speed / (p.ball_speed_max * p.ball_decay)
            largest = p.kick_noise * p.kick_rand * power / 100.0 * (position_rate + speed_rate)
            magnitude = largest * self.random.random()
            angle = PI * (2.0 * self.random.random() - 1.0)
            ball.ax += magnitude * math.cos(angle)
            ball.ay += magnitude * math.sin(angle)
        return True

    def advance(self) -> None:
        """Move everything by one cycle."""
        random = self.random.random
        for mover in self.movers:
            vx, vy = mover.vx, mover.vy
            ax, ay = mover.ax, mover.ay
            if ax or ay:
                size = math.hypot(ax, ay)
                if size > mover.acceleration_max:
                    ax *= mover.acceleration_max / size
                    ay *= mover.acceleration_max / size
                vx += ax
                vy += ay
                speed = math.hypot(vx, vy)
                if speed > mover.speed_max:
                    vx *= mover.speed_max / speed
                    vy *= mover.speed_max / speed
                mover.ax = mover.ay = 0.0
            if mover.rand and (vx or vy):
                magnitude = mover.rand * math.hypot(vx, vy) * random()
                angle = PI * (2.0 * random() - 1.0)
                vx += magnitude * math.cos(angle)
                vy += magnitude * math.sin(angle)
            mover.vx, mover.vy = vx, vy
            mover.body.velocity = vx, vy
        self._space.step(1.0)
        for mover in self.movers:
            mover.x, mover.y = mover.body.position
            mover.vx *= mover.decay
            mover.vy *= mover.decay
        if self._touching:
            pairs = [self._pair(*shapes) for shapes in self._touching]
            self._touching.clear()
            self._separate(pairs)

    def _pair(self, a: pymunk.Shape, b: pymunk.Shape) -> tuple[int, int]:
        first, second = self._by_shape[a].index, self._by_shape[b].index
        return (first, second) if first < second else (second, first)

    def _separate(self, pairs: list[tuple[int, int]]) -> None:
        """Move overlapping bodies apart, each by half; a body in several pairs, by the mean."""
        collided: set[int] = set()
        for _ in range(COLLISION_ROUNDS):
            if not pairs:
                break
            sums: dict[int, tuple[float, float, int]] = {}
            for first, second in sorted(pairs):  # pymunk's order must not matter
                a, b = self.movers[first], self.movers[second]
                ux, uy = self._apart(a, b)
                reach = (a.radius + b.radius) / 2.0 + SEPARATION
                middle_x, middle_y = (a.x + b.x) / 2.0, (a.y + b.y) / 2.0
                for index, side in ((first, reach), (second, -reach)):
                    x, y, count = sums.get(index, (0.0, 0.0, 0))
                    sums[index] = (x + middle_x + side * ux, y + middle_y + side * uy, count + 1)
            for index, (x, y, count) in sums.items():
                mover = self.movers[index]
                self.put(mover, x / count, y / count, mover.heading, mover.vx, mover.vy)
            collided.update(sums)
            found = set()
            for index in sums:
                shape = self.movers[index].shape
                for info in self._space.shape_query(shape):
                    if info.shape is not None:
                        found.add(self._pair(shape, info.shape))
            pairs = [pair for pair in found if self._overlap(*pair)]
        for index in collided:
            mover = self.movers[index]
            mover.vx *= REBOUND
            mover.vy *= REBOUND

    def _overlap(self, first: int, second: int) -> bool:
        a, b = self.movers[first], self.movers[second]
        return math.hypot(a.x - b.x, a.y - b.y) < a.radius + b.radius

    def _apart(self, a: Mover, b: Mover) -> tuple[float, float]:
        """Return the unit vector from ``b`` to ``a``; any, if they coincide."""
        dx, dy = a.x - b.x, a.y - b.y
        distance = math.hypot(dx, dy)
        if distance < SEPARATION:
            angle = PI * (2.0 * self.random.random() - 1.0)
            return math.cos(angle), math.sin(angle)
        return dx / distance, dy / distance
