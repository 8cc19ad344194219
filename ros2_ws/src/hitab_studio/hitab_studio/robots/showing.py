"""Robots as a field that pages draw: where they are, what their scanners see, how large all is.

What scanners see is a binary frame, little-endian, like those of the things in a field:

    uint32  2, uint32 number of robots
    uint32  index of the robot, uint32 n, float32 x, y of each point, n times; for each robot
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from hitab_core import natural
from hitab_studio.robots.frames import Matrix
from hitab_studio.scene import Look, Scene

Place = tuple[float, float, float]
"""x, y in m and heading in rad."""

Box = tuple[float, float, float, float]
"""Left, bottom, right and top, m."""

SPARE = 5.0
"""By how much the ground may be too large."""

RADIUS = 0.2
"""m; how large robots are drawn, since no message says how large they are."""

STEP = 1.0
"""m; the ground grows by so much at a time, lest the page move all the time."""

LEAST = 2.0
"""m; from a robot to the edge of the ground."""

SCAN_FRAME = 2


class Ground:
    """How much is drawn: all robots, points and the map, and what there was before."""

    def __init__(self) -> None:
        self._frame: str | None = None
        self._box: Box | None = None

    def grown(
        self,
        frame: str,
        places: Mapping[str, Place],
        points: Mapping[str, Sequence[Matrix]],
        corners: Matrix | None,
    ) -> tuple[float, float, float, float]:
        """Return center x, y, width and height, m.

        Args:
            frame: in which all is; of another one, nothing that was before counts.
            places: of robots.
            points: that their scanners see, shape (n, 2).
            corners: of the map, shape (n, 2).
        """
        if frame != self._frame:
            self._frame, self._box = frame, None
        boxes = [(x - LEAST, y - LEAST, x + LEAST, y + LEAST) for x, y, _ in places.values()]
        clouds = [some for several in points.values() for some in several if len(some)]
        for cloud in [*clouds, *([corners] if corners is not None else [])]:
            boxes.append((*cloud.min(0).tolist(), *cloud.max(0).tolist()))
        if not boxes:
            return 0.0, 0.0, 2 * LEAST, 2 * LEAST
        needed = _around(boxes)
        if self._box is None or not _is_much_larger(self._box, needed):
            needed = _around([needed, *([self._box] if self._box is not None else [])])
        self._box = needed
        left, bottom, right, top = needed
        return (left + right) / 2, (bottom + top) / 2, right - left, top - bottom


def _around(boxes: Sequence[Box]) -> Box:
    """Return the box around others, in steps."""
    left, bottom = (math.floor(min(box[i] for box in boxes) / STEP) * STEP for i in (0, 1))
    right, top = (math.ceil(max(box[i] for box in boxes) / STEP) * STEP for i in (2, 3))
    return left, bottom, right, top


def _is_much_larger(box: Box, needed: Box) -> bool:
    """Whether a box comes of a place that a robot has left for good, or has never been at."""
    return any(box[i + 2] - box[i] > SPARE * (needed[i + 2] - needed[i]) for i in (0, 1))


def robot_scene(places: Mapping[str, Place], ground: tuple[float, float, float, float]) -> Scene:
    """Return the field with the robots.

    It has no cycles, so that no command is taken to mean a moment of a world.
    """
    names = sorted(places, key=natural)
    rows = np.array([(*places[name], 0.0, 0.0) for name in names], dtype=np.float64)
    rows.setflags(write=False)
    return Scene(
        world="",
        cycle=0,
        episode=0,
        episode_cycle=0,
        mode="",
        note="",
        seconds=0.0,
        size=ground[2:],
        names=tuple(names),
        kinds=("robot",) * len(names),
        radii=(RADIUS,) * len(names),
        places=rows,
        said=MappingProxyType({}),
        looks=MappingProxyType({"robot": Look()}),
        center=ground[:2],
        real=True,
    )


def scans_frame(names: Sequence[str], points: Mapping[str, Sequence[Matrix]]) -> bytes:
    """Return the frame of what scanners see; of robots without a place, nothing."""
    parts = []
    for i, name in enumerate(names):
        seen = [some for some in points.get(name, ()) if len(some)]
        cloud = np.concatenate(seen) if seen else np.empty((0, 2))
        parts.append(struct.pack("<II", i, len(cloud)) + cloud.astype("<f4").tobytes())
    return struct.pack("<II", SCAN_FRAME, len(parts)) + b"".join(parts)
