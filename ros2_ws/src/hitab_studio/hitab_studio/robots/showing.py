"""Robots as a field that pages draw: where they are, what their scanners see, how large all is.

What scanners see is a binary frame, little-endian, like those of the things in a field:

    uint32  2, uint32 number of robots
    uint32  index of the robot, uint32 n, float32 x, y of each point, n times; for each robot
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from hitab_core import natural
from hitab_studio.robots.frames import Matrix
from hitab_studio.scene import Look, Scene

Place = tuple[float, float, float]
"""x, y in m and heading in rad."""

RADIUS = 0.2
"""m; how large robots are drawn, since no message says how large they are."""

STEP = 5.0
"""m; the ground grows by so much at a time, lest the page move all the time."""

LEAST = 2.0
"""m; from a robot to the edge of the ground."""

SCAN_FRAME = 2


def ground(
    places: Mapping[str, Place],
    points: Mapping[str, Sequence[Matrix]],
    corners: Matrix | None,
) -> tuple[float, float, float, float]:
    """Return center x, y, width and height of what holds all that is drawn, m.

    Args:
        places: of robots.
        points: that their scanners see, shape (n, 2).
        corners: of the map, shape (n, 2).
    """
    around = np.array([[-LEAST, -LEAST], [LEAST, LEAST]])
    drawn = [np.array([[x, y]]) + around for x, y, _ in places.values()] or [around]
    drawn += [some for several in points.values() for some in several]
    drawn += [corners] if corners is not None else []
    all_ = np.concatenate(drawn)
    low, high = np.floor(all_.min(0) / STEP) * STEP, np.ceil(all_.max(0) / STEP) * STEP
    (x, y), (width, height) = ((low + high) / 2).tolist(), (high - low).tolist()
    return x, y, width, height


def robot_scene(places: Mapping[str, Place], size: tuple[float, float, float, float]) -> Scene:
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
        size=size[2:],
        names=tuple(names),
        kinds=("robot",) * len(names),
        radii=(RADIUS,) * len(names),
        places=rows,
        said=MappingProxyType({}),
        looks=MappingProxyType({"robot": Look()}),
        center=size[:2],
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
