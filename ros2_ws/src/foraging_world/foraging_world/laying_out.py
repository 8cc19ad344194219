"""The layout of the field at the beginning of an episode, and the places of returned boxes."""

from __future__ import annotations

import math

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from foraging_world.parameters import ForagingParameters
from hitab_world.parameters import ParameterError

Floats = NDArray[np.float64]

LAYOUT_TRIES = 2000
SPREAD = 0.35  # m: the distance from the middle grows with the root of the forager's number
GOLDEN_ANGLE = math.pi * (3.0 - math.sqrt(5.0))


def start_places(p: ForagingParameters) -> Floats:
    """Return the start positions of the foragers: a dense spiral around home."""
    number = np.arange(1, p.foragers + 1)
    distance = SPREAD * (p.forager_radius / 0.2) * np.sqrt(number)
    angle = number * GOLDEN_ANGLE
    return np.stack([distance * np.cos(angle), distance * np.sin(angle)], axis=1)


def clear_radius(p: ForagingParameters) -> float:
    """Return the radius around the middle, m, that is kept clear for home and the foragers."""
    spread = SPREAD * (p.forager_radius / 0.2) * math.sqrt(p.foragers) + p.forager_radius
    return max(spread, p.home_radius) + p.largest_radius


def obstacle_places(p: ForagingParameters, random: Generator) -> Floats:
    """Return the positions of the obstacles; a large box can be pulled between any two.

    Raises:
        ParameterError: if there is no room for that many.
    """
    passage, radius = 2.0 * p.largest_radius + 0.5, p.obstacle_radius
    places: list[Floats] = []
    for _ in range(p.obstacles):
        taken = np.array(places).reshape(-1, 2)
        distances = np.full(len(places), passage + 2.0 * radius)
        middle = clear_radius(p) + radius
        place = _free_place(p, random, passage + radius, middle, taken, distances)
        if place is None:
            raise ParameterError(
                f"there is no room for {p.obstacles} obstacles, with passages for large boxes, on "
                f"{p.width:g} m by {p.height:g} m; use a larger field or fewer obstacles"
            )
        places.append(place)
    return np.array(places).reshape(-1, 2)


def box_place(
    p: ForagingParameters, random: Generator, radius: float, taken: Floats, radii: Floats
) -> Floats | None:
    """Return where a box can lie: away from home, the walls and everything else.

    Args:
        radius: radius of the box, m.
        taken, radii: centers and radii of the things that the box and its pullers must not touch.
    """
    ring = radius + p.ring_width
    return _free_place(p, random, ring, clear_radius(p) + radius, taken, radii + ring)


def _free_place(
    p: ForagingParameters,
    random: Generator,
    from_walls: float,
    from_middle: float,
    taken: Floats,
    distances: Floats,
) -> Floats | None:
    x, y = p.width / 2.0 - from_walls, p.height / 2.0 - from_walls
    if x <= 0.0 or y <= 0.0:
        return None
    for _ in range(LAYOUT_TRIES):
        place = random.uniform((-x, -y), (x, y))
        if np.hypot(*place) < from_middle:
            continue
        away = np.hypot(*(taken - place).T) if len(taken) else distances
        if np.all(away >= distances):
            return place
    return None
