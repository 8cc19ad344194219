"""The mount of a sensor: its place on the robot."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Mount:
    """The place of a sensor in the robot's frame (REP 103: x ahead, y left).

    Attributes:
        x, y: m.
        yaw: direction in which the sensor faces, rad, counter-clockwise from ahead.
        upside_down: whether the sensor is turned over about its x axis, so that its angles grow
            clockwise.
    """

    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    upside_down: bool = False

    @classmethod
    def of_transform(
        cls, translation: tuple[float, float, float], rotation: tuple[float, float, float, float]
    ) -> Mount:
        """Return the mount for a transform from the sensor's frame to the robot's.

        Args:
            translation: x, y, z in m.
            rotation: a quaternion x, y, z, w.
        """
        qx, qy, qz, qw = rotation
        # The sensor's x and z axes in the robot's frame.
        yaw = math.atan2(2.0 * (qx * qy + qw * qz), 1.0 - 2.0 * (qy * qy + qz * qz))
        up = 1.0 - 2.0 * (qx * qx + qy * qy)
        return cls(translation[0], translation[1], yaw, up < 0.0)

    def points(self, distances: Floats, angles: Floats) -> tuple[Floats, Floats]:
        """Return distances in m and bearings in rad of things, as seen from the robot.

        Args:
            distances: distances from the sensor, m, shape (n,).
            angles: directions in the sensor's frame, rad, shape (n,).
        """
        facing = self.yaw + (-angles if self.upside_down else angles)
        x = self.x + distances * np.cos(facing)
        y = self.y + distances * np.sin(facing)
        return np.hypot(x, y), np.arctan2(y, x)
