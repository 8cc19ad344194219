"""The percepts of all foragers on a field, in the layout of `foraging_world.percept`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from foraging_world.field import Field
from foraging_world.percept import (
    ATTACHED_BOX,
    BOX,
    COMPANY_BOX,
    HANDS,
    HEADING,
    HELD,
    HELD_SIZE,
    HOME,
    LARGE,
    LARGE_BOX,
    NOT_SEEN_M,
    NUMBER,
    OBSTACLE,
    PERCEPT_LENGTH,
    REACH,
    RESTED,
    SCOUT,
    SCOUTED_BOX,
    SMALL,
    SMALL_BOX,
    SQUAD_BOX,
    SQUAD_CENTRE,
    WAITED,
    X,
    Y,
)

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


def perceive_all(field: Field) -> Floats:
    """Return the percepts of all foragers; shape (foragers, LENGTH)."""
    p = field.parameters
    foragers = p.foragers
    senses = np.zeros((foragers, PERCEPT_LENGTH))
    xy, heading = field.xy, field.heading
    senses[:, NUMBER] = np.arange(1, foragers + 1)
    senses[:, X : Y + 1] = xy
    senses[:, HEADING] = heading
    senses[:, WAITED] = field.waited
    senses[:, RESTED] = field.rested
    senses[:, REACH] = field.reach
    senses[:, HOME:PERCEPT_LENGTH:3] = NOT_SEEN_M

    def put(place: int, to: Floats, gap: Floats, numbers: Ints | None, seen: NDArray) -> None:
        """Fill a place: vectors, distances and box numbers, where something is seen."""
        direction = np.arctan2(to[:, 1], to[:, 0]) - heading
        direction -= 2.0 * np.pi * np.round(direction / (2.0 * np.pi))
        senses[:, place] = np.where(seen, np.maximum(gap, 0.0), NOT_SEEN_M)
        senses[:, place + 1] = np.where(seen, direction, 0.0)
        if numbers is not None:
            senses[:, place + 2] = np.where(seen, numbers + 1, 0)

    everyone = np.ones(foragers, bool)
    put(HOME, -xy, np.hypot(xy[:, 0], xy[:, 1]), None, everyone)
    middle = squad_means(xy, p.squad_size) - xy
    put(SQUAD_CENTRE, middle, np.hypot(middle[:, 0], middle[:, 1]), None, everyone)
    put(OBSTACLE, *_closest_obstacle(field))
    scout = xy[np.arange(foragers) // p.squad_size * p.squad_size] - xy
    put(SCOUT, scout, np.hypot(scout[:, 0], scout[:, 1]), None, everyone & (p.scouts > 0))
    senses[senses[:, OBSTACLE] == NOT_SEEN_M, OBSTACLE + 1] = np.pi
    if len(field.box_xy):
        _put_boxes(field, senses, put)
    return senses


def _put_boxes(field: Field, senses: Floats, put) -> None:
    p, held = field.parameters, field.held
    xy, boxes = field.xy, field.box_xy
    foragers, rows = p.foragers, np.arange(p.foragers)
    holds = held >= 0
    senses[:, HELD] = held + 1
    senses[:, HELD_SIZE] = np.where(holds, np.where(field.large[held], LARGE, SMALL), 0.0)
    senses[:, HANDS] = np.where(holds, field.hands[held], 0)

    seen = _in_sight(xy, boxes, field.box_radius + p.forager_radius, field.sight)
    seen = seen.where(field.present[seen.thing])
    others_hold = field.hands[seen.thing] > (held[seen.forager] == seen.thing)
    large = field.large[seen.thing]
    for place, closest in (
        (BOX, seen.closest()),
        (SMALL_BOX, seen.where(~large).closest()),
        (LARGE_BOX, seen.where(large).closest()),
        (ATTACHED_BOX, seen.where(others_hold).closest()),
    ):
        chosen, gap = closest.spread(foragers)
        put(place, boxes[chosen] - xy, gap, chosen, np.isfinite(gap))

    squads = rows // p.squad_size
    held_by_squad = np.zeros((len(rows), len(boxes)), bool)
    held_by_squad[squads[holds], held[holds]] = True
    scouted = seen.where(
        field.scouts[seen.forager] & ~held_by_squad[squads[seen.forager], seen.thing]
    )
    chosen, gap = scouted.by(squads).closest().spread(foragers)
    chosen, known = chosen[squads], np.isfinite(gap[squads])
    to = boxes[chosen] - xy
    gap = np.hypot(to[:, 0], to[:, 1]) - (field.box_radius[chosen] + p.forager_radius)
    put(SCOUTED_BOX, to, gap, chosen, known)

    for place, groups, which in (
        (SQUAD_BOX, squads, holds),
        (COMPANY_BOX, squads // p.company_squads, holds & field.large[held]),
    ):
        counts = np.bincount(
            groups[which] * len(boxes) + held[which],
            minlength=(int(groups[-1]) + 1) * len(boxes),
        ).reshape(-1, len(boxes))
        favorite = counts.argmax(axis=1)
        chosen = favorite[groups]
        known = counts.max(axis=1)[groups] > 0
        to = boxes[chosen] - xy
        gap = np.hypot(to[:, 0], to[:, 1]) - (field.box_radius[chosen] + p.forager_radius)
        put(place, to, gap, chosen, known)


@dataclass(frozen=True)
class _Sightings:
    """Pairs of a forager and a thing in its sight, sorted by forager, then by distance.

    Attributes:
        forager, thing: the indices of each pair.
        gap: distance from edge to edge, m.
    """

    forager: Ints
    thing: Ints
    gap: Floats

    def where(self, mask: NDArray) -> _Sightings:
        """Return the sightings of a mask."""
        return _Sightings(self.forager[mask], self.thing[mask], self.gap[mask])

    def by(self, groups: Ints) -> _Sightings:
        """Return the sightings with each forager replaced by its group."""
        order = np.lexsort((self.gap, groups[self.forager]))
        return _Sightings(groups[self.forager][order], self.thing[order], self.gap[order])

    def closest(self) -> _Sightings:
        """Return the closest thing to each forager that sees anything."""
        if not len(self.forager):
            return self
        return self.where(np.diff(self.forager, prepend=-1) != 0)

    def spread(self, foragers: int) -> tuple[Ints, Floats]:
        """Return the thing in each forager's sight, and its distance; infinite if none."""
        thing, gap = np.zeros(foragers, np.int64), np.full(foragers, np.inf)
        thing[self.forager] = self.thing
        gap[self.forager] = self.gap
        return thing, gap


def _in_sight(xy: Floats, things: Floats, radii: Floats, sight: Floats) -> _Sightings:
    """Return the sightings of all foragers; ``radii`` are sums of a thing's and a forager's.

    Args:
        sight: range of sight of each forager, m.
    """
    dx = things[:, 0] - xy[:, 0, None]
    dy = things[:, 1] - xy[:, 1, None]
    forager, thing = np.nonzero(dx * dx + dy * dy <= (sight[:, None] + radii) ** 2 + 1e-9)
    gap = np.hypot(dx[forager, thing], dy[forager, thing]) - radii[thing]
    order = np.lexsort((thing, gap, forager))
    found = _Sightings(forager[order], thing[order], gap[order])
    return found.where(found.gap <= sight[found.forager])


def squad_means(xy: Floats, squad_size: int) -> Floats:
    """Return the mean position of each forager's squad; shape (foragers, 2)."""
    squads = np.arange(len(xy)) // squad_size
    sizes = np.bincount(squads)
    means = np.stack([np.bincount(squads, xy[:, i]) / sizes for i in (0, 1)], axis=1)
    return means[squads]


def _closest_obstacle(field: Field) -> tuple[Floats, Floats, None, NDArray]:
    """Return the vectors and distances to the closest obstacle or wall."""
    p, xy = field.parameters, field.xy
    rows = np.arange(len(xy))
    half = np.array([p.width, p.height]) / 2.0
    to = [
        np.where(np.arange(2) == axis, side * half - xy, 0.0)
        for axis in (0, 1)
        for side in (1.0, -1.0)
    ]
    gaps = [np.hypot(wall[:, 0], wall[:, 1]) for wall in to]
    radius = np.full(len(field.obstacles), p.obstacle_radius + p.forager_radius)
    seen = _in_sight(xy, field.obstacles, radius, np.full(len(xy), p.obstacle_sight))
    closest, away = seen.closest().spread(len(xy))
    if len(field.obstacles):
        to.append(field.obstacles[closest] - xy)
        gaps.append(away + p.forager_radius)
    every_gap = np.stack(gaps, axis=1) - p.forager_radius
    chosen = every_gap.argmin(axis=1)
    gap = every_gap[rows, chosen]
    return np.stack(to, axis=1)[rows, chosen], gap, None, gap <= p.obstacle_sight
