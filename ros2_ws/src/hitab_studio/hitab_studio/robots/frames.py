"""Frames and the ways between them, as tf tells these; the newest of each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
"""A motion as a matrix of shape (4, 4): takes points of one frame to another one."""

FRAMES_MAX = 2000
"""Frames that are kept, whatever anybody publishes."""


def matrix(translation: Sequence[float], rotation: Sequence[float]) -> Matrix | None:
    """Return a motion; None if the rotation is no quaternion (x, y, z, w), as zeros are none."""
    length = math.sqrt(sum(part * part for part in rotation))
    if not (0.5 < length < 2.0 and all(map(math.isfinite, translation))):
        return None
    x, y, z, w = (part / length for part in rotation)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), translation[0]],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), translation[1]],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), translation[2]],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def in_plane(x: float, y: float, yaw: float, *, upside_down: bool = False) -> Matrix:
    """Return a motion in the plane, of what is turned over about its own x axis first."""
    c, s, up = math.cos(yaw), math.sin(yaw), -1.0 if upside_down else 1.0
    return np.array(
        [[c, -up * s, 0.0, x], [s, up * c, 0.0, y], [0.0, 0.0, up, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )


def planar(motion: Matrix) -> Matrix:
    """Return what a motion is in the plane."""
    x, y = motion[:2, 3].tolist()
    return in_plane(x, y, heading(motion))


def heading(motion: Matrix) -> float:
    """Return by how much a motion turns in the plane, rad."""
    return math.atan2(motion[1, 0], motion[0, 0])


def applied(motion: Matrix, points: Matrix) -> Matrix:
    """Return points of a plane in another frame, both of shape (n, 2)."""
    moved: Matrix = points @ motion[:2, :2].T + motion[:2, 3]
    return moved


class Frames:
    """The tree of frames."""

    def __init__(self) -> None:
        self._above: dict[str, tuple[str, Matrix]] = {}

    def take(self, message: Any) -> None:
        """Take a `tf2_msgs/TFMessage`; what makes no sense in it is left out."""
        for transform in message.transforms:
            place, turn = transform.transform.translation, transform.transform.rotation
            motion = matrix((place.x, place.y, place.z), (turn.x, turn.y, turn.z, turn.w))
            child = transform.child_frame_id.lstrip("/")
            if motion is not None and (child in self._above or len(self._above) < FRAMES_MAX):
                self._above[child] = (transform.header.frame_id.lstrip("/"), motion)

    def _ways_up(self, frame: str) -> dict[str, Matrix]:
        """Return the frames above a frame, and itself, with the ways there."""
        ways = {frame: np.eye(4)}
        while (found := self._above.get(frame)) is not None and found[0] not in ways:
            ways[found[0]] = found[1] @ ways[frame]
            frame = found[0]
        return ways

    def way(self, to: str, from_: str) -> Matrix | None:
        """Return the motion that takes points of a frame to another one; None: none is known."""
        to, from_ = to.lstrip("/"), from_.lstrip("/")
        up = self._ways_up(to)
        for frame, motion in self._ways_up(from_).items():
            if frame in up:
                found: Matrix = np.linalg.inv(up[frame]) @ motion
                return found
        return None
