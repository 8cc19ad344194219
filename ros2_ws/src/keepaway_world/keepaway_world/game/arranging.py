"""The things on a field: how viewers see them, and how they are placed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

from hitab_core import has
from hitab_world import Entity, Placement, WorldError
from keepaway_world.game.physics import Mover, Physics
from keepaway_world.percept import CYCLES_PER_SECOND

PLACED_DISTANCE_MAX = 1000.0
"""Largest distance from the center of the field, m, at which something can be placed."""

Place = tuple[float, float, float, float, float]
"""x, y, heading, vx, vy: m, rad and m/cycle, y up."""


def entities_of(physics: Physics, said: Mapping[str, str]) -> list[Entity]:
    """Return the ball and the players in SI units, and what they said."""
    return [
        Entity(
            mover.name,
            mover.kind,
            mover.x,
            mover.y,
            mover.heading,
            mover.vx * CYCLES_PER_SECOND,
            mover.vy * CYCLES_PER_SECOND,
            mover.radius,
            said.get(mover.name, ""),
        )
        for mover in physics.movers
    ]


def places_of(physics: Physics) -> dict[str, Place]:
    """Return where everything is, by name."""
    return {m.name: (m.x, m.y, m.heading, m.vx, m.vy) for m in physics.movers}


def placed(placements: Iterable[Placement], movers: Mapping[str, Mover]) -> dict[str, Place]:
    """Return the requested places, with NaN replaced by the current values.

    Raises:
        WorldError: naming a thing that does not exist, or a place or speed that is impossible.
    """
    places: dict[str, Place] = {}
    for p in placements:
        mover = movers.get(p.name)
        if mover is None:
            raise WorldError(f'nothing is called "{p.name}" {has(movers, p.name)}')
        given = (p.x, p.y, p.heading, p.vx / CYCLES_PER_SECOND, p.vy / CYCLES_PER_SECOND)
        now = (mover.x, mover.y, mover.heading, mover.vx, mover.vy)
        if any(math.isinf(value) for value in given):
            raise WorldError(f"{p.name}: a value is infinite; give a number or NaN")
        x, y, heading, vx, vy = (
            old if math.isnan(new) else float(new) for new, old in zip(given, now, strict=True)
        )
        if max(abs(x), abs(y)) > PLACED_DISTANCE_MAX:
            raise WorldError(
                f"{p.name}: ({x:g}, {y:g}) m is beyond {PLACED_DISTANCE_MAX:g} m; give it a place "
                "near the field, whose center is (0, 0)"
            )
        if math.hypot(vx, vy) > mover.speed_max * 1.001:
            raise WorldError(
                f"{p.name}: a speed of {math.hypot(vx, vy) * CYCLES_PER_SECOND:.2f} m/s exceeds "
                f"its maximum, {mover.speed_max * CYCLES_PER_SECOND:g} m/s"
            )
        places[p.name] = x, y, math.remainder(heading, 2.0 * math.pi), vx, vy
    return places
