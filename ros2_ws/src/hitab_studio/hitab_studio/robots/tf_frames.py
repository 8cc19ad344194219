"""Frames and the newest transforms between them, from tf."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

Matrix = NDArray[np.float64]
"""A rigid transform of points from one frame to another, as a matrix of shape (4, 4)."""

FRAMES_MAX = 2000
"""Maximum number of frames, against endless new names on tf."""

PLACE_MAX = 1e5
"""Maximum coordinate of a place that can be shown, m."""


def matrix(place: Any, turn: Any) -> Matrix | None:
    """Return the transform of a translation and a quaternion; None if either is invalid."""
    length = math.hypot(turn.x, turn.y, turn.z, turn.w)
    if not 0.5 < length < 2.0 or not all(abs(n) < PLACE_MAX for n in (place.x, place.y, place.z)):
        return None
    x, y, z, w = (part / length for part in (turn.x, turn.y, turn.z, turn.w))
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), place.x],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), place.y],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), place.z],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def in_plane(motion: Matrix) -> tuple[float, float, float]:
    """Return the planar part of a transform: x and y, m, and the yaw, rad."""
    x, y = motion[:2, 3].tolist()
    return x, y, math.atan2(motion[1, 0], motion[0, 0])


def applied(motion: Matrix, points: Matrix) -> Matrix:
    """Return planar points transformed to another frame; both arrays have shape (n, 2)."""
    moved: Matrix = points @ motion[:2, :2].T + motion[:2, 3]
    return moved


class Frames:
    """The tree of frames, as received on tf."""

    def __init__(self) -> None:
        self._above: dict[str, tuple[str, Matrix]] = {}

    def take(self, message: Any) -> None:
        """Take a `tf2_msgs/TFMessage`, without the invalid transforms in it."""
        for transform in message.transforms:
            motion = matrix(transform.transform.translation, transform.transform.rotation)
            child = transform.child_frame_id.lstrip("/")
            if motion is not None and (child in self._above or len(self._above) < FRAMES_MAX):
                self._above[child] = (transform.header.frame_id.lstrip("/"), motion)

    def _ways_up(self, frame: str) -> dict[str, Matrix]:
        """Return the transforms from a frame to itself and to each ancestor, by name."""
        ways = {frame: np.eye(4)}
        while (found := self._above.get(frame)) is not None and found[0] not in ways:
            ways[found[0]] = found[1] @ ways[frame]
            frame = found[0]
        return ways

    def way(self, to: str, from_: str) -> Matrix | None:
        """Return the transform of points from one frame to another; None if unknown."""
        up = self._ways_up(to.lstrip("/"))
        for frame, motion in self._ways_up(from_.lstrip("/")).items():
            if frame in up:
                found: Matrix = np.linalg.inv(up[frame]) @ motion
                return found
        return None
