"""The robots, boxes and obstacles as pymunk bodies, which move by one cycle at a time.

A cycle depends only on the given positions and velocities, so that a world restored from a
snapshot continues bit for bit like the original:

* bodies and shapes are added once, in a fixed order, and found by a spatial hash, which is
  refilled in each step;
* pymunk keeps the impulses of touching bodies for the next step. The solver forgets contacts in a
  step without any, so one such step, with everything far apart, ends a cycle.
"""

from __future__ import annotations

import math

import numpy as np
import pymunk
from numpy.typing import NDArray
from pymunk.batch import BodyFields, Buffer, get_space_bodies, set_space_bodies

from foraging_world.parameters import ForagingParameters

Floats = NDArray[np.float64]

FORAGER, BOX, RING, OBSTACLE = 1, 2, 4, 8  # categories of shapes
FORAGER_MASS, BOX_MASS = 1.0, 10_000.0
ITERATIONS = 4
SLOP = 0.005  # m: how much bodies may overlap
BIAS = 1e-6  # fraction of an overlap that is left after a second
WALL = 2.0  # m: thickness of walls, so that no robot is pushed through
APART = 1e4  # m: distance between bodies while the solver forgets their contacts


class Bodies:
    """A pymunk space with foragers and boxes in it, in this order.

    Boxes are round, so that they slide off obstacles. Each has a ring around it, in which its
    pullers walk; the ring only collides with obstacles and walls.

    Args:
        parameters: counts, sizes.
        box_radius: radius of each box, m.
        obstacles: centers, shape (obstacles, 2), m.
    """

    def __init__(
        self, parameters: ForagingParameters, box_radius: Floats, obstacles: Floats
    ) -> None:
        p = parameters
        self._space = space = pymunk.Space()
        space.iterations = ITERATIONS
        space.collision_slop = SLOP
        space.collision_bias = BIAS
        space.collision_persistence = 1
        count = p.foragers + len(box_radius)
        space.use_spatial_hash(4.0 * p.forager_radius, 10 * count + 100)
        self._add_obstacles(p, obstacles)
        for _ in range(p.foragers):
            self._add(FORAGER_MASS, [(p.forager_radius, FORAGER, FORAGER | BOX | OBSTACLE)])
        for radius in box_radius.tolist():
            ring = radius + p.ring_width
            self._add(BOX_MASS, [(radius, BOX, FORAGER | BOX), (ring, RING, OBSTACLE)])
        # pymunk's batches end with a row for the static body, which stays at the origin.
        self._given = np.zeros((count + 1, 4))
        apart = np.zeros((count + 1, 4))
        apart[:count, 0] = APART * np.arange(1, count + 1)
        self._buffer, self._apart, self._found = Buffer(), Buffer(), Buffer()
        self._buffer.set_float_buf(self._given.reshape(-1))
        self._apart.set_float_buf(apart.reshape(-1))

    def _add(self, mass: float, shapes: list[tuple[float, int, int]]) -> None:
        body = pymunk.Body(mass, math.inf)
        made = []
        for radius, category, mask in shapes:
            shape = pymunk.Circle(body, radius)
            shape.filter = pymunk.ShapeFilter(categories=category, mask=mask)
            made.append(shape)
        self._space.add(body, *made)

    def _add_obstacles(self, p: ForagingParameters, obstacles: Floats) -> None:
        static = self._space.static_body
        x, y = p.width / 2.0 + WALL, p.height / 2.0 + WALL
        corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
        shapes: list[pymunk.Shape] = [
            pymunk.Segment(static, corners[i - 1], corners[i], WALL) for i in range(4)
        ]
        shapes += [
            pymunk.Circle(static, p.obstacle_radius, center) for center in obstacles.tolist()
        ]
        for shape in shapes:
            shape.filter = pymunk.ShapeFilter(categories=OBSTACLE, mask=FORAGER | RING)
        self._space.add(*shapes)

    def step(self, xy: Floats, velocity: Floats, seconds: float) -> Floats:
        """Return the positions of all bodies after moving with these velocities.

        Args:
            xy: present positions, foragers first, then boxes; shape (bodies, 2), m.
            velocity: the same shape, m/s.
            seconds: duration, s.
        """
        space, fields = self._space, BodyFields.POSITION | BodyFields.VELOCITY
        # pymunk first moves bodies and then detects contacts, which change velocities and push
        # apart in the next step. So one step leads to the present positions, the next one moves.
        self._given[:-1, :2] = xy - velocity * seconds
        self._given[:-1, 2:] = velocity
        set_space_bodies(space, fields, self._buffer)
        space.step(seconds)
        space.step(seconds)
        self._found.clear()
        get_space_bodies(space, BodyFields.POSITION, self._found)
        found = np.frombuffer(self._found.float_buf()).reshape(-1, 2)[:-1].copy()
        set_space_bodies(space, fields, self._apart)
        space.step(seconds)  # forgets what touched
        return found
