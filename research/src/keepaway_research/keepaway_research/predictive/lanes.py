"""Passing lanes: how far the takers are from the path of a pass."""

from __future__ import annotations

import math
from collections.abc import Iterable

from keepaway_research.predictive.forecast import Point


def clearance(start: Point, end: Point, players: Iterable[Point]) -> float:
    """Return the distance of the nearest player to the line from start to end, m.

    Infinite without players.
    """
    (x, y), (end_x, end_y) = start, end
    along_x, along_y = end_x - x, end_y - y
    squared = along_x * along_x + along_y * along_y
    least = math.inf
    for player_x, player_y in players:
        dx, dy = player_x - x, player_y - y
        part = (dx * along_x + dy * along_y) / squared if squared > 0.0 else 0.0
        part = min(max(part, 0.0), 1.0)
        least = min(least, math.hypot(dx - part * along_x, dy - part * along_y))
    return least
