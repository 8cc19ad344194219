"""A laser scanner as a few numbers: the nearest return in each sector."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from hitab_robots.mount import Mount
from hitab_robots.sensors import Sensor, check_name

ANGLE_TOLERANCE = 1e-6
"""How far outside of a sector a ray may be, rad, since angles are sums in single precision."""


@dataclass(frozen=True)
class Sector:
    """A part of the circle around the robot.

    Attributes:
        name: a word, such as ``ahead``.
        center: middle of the sector, rad, counter-clockwise from ahead.
        width: from edge to edge, rad; the whole circle by default.
    """

    name: str
    center: float = 0.0
    width: float = math.tau

    def __post_init__(self) -> None:
        check_name("a sector", self.name)


AROUND = Sector("around")
CENTER = Mount()


@dataclass(frozen=True, kw_only=True)
class Scan(Sensor):
    """A `sensor_msgs/LaserScan`: ``range`` and ``bearing`` of the nearest return in each sector.

    Both values are relative to the robot's center, whatever the scanner's mount is. If nothing is
    within range in a sector, the range is ``max_range`` and the bearing is NaN. Both are NaN if
    the sector is unknown: no ray of the scanner is in it, or fewer than half of its rays measured
    anything.

    A ray means what REP 117 says: NaN and values below ``range_min`` are no measurements; negative
    infinity is a thing too near to be measured, and counts as ``range_min``; from the maximum on
    there is nothing. A scan of several rays with an angle increment of 0 is unknown as a whole.

    Attributes:
        sectors: parts of the scan, each with two values, such as ``scan.ahead.range``.
        max_range: largest range, m; None for the scanner's ``range_max``. Needed if robots with
            different scanners should share behaviors.
        zero_is_clear: whether a range of 0.0 means that nothing is there, as with the drivers of
            some small scanners, and not that nothing was measured.
    """

    message: ClassVar[str] = "sensor_msgs/msg/LaserScan"
    name: str = "scan"
    sectors: tuple[Sector, ...] = (AROUND,)
    mount: Mount | None = CENTER
    max_range: float | None = None
    zero_is_clear: bool = False

    def __post_init__(self) -> None:
        super().__post_init__()
        self.check_distinct("sectors", [sector.name for sector in self.sectors])

    @property
    def fields(self) -> tuple[str, ...]:
        """The names of the sensor's values."""
        return tuple(f"{s.name}.{what}" for s in self.sectors for what in ("range", "bearing"))

    def read(self, message: Any, mount: Mount | None = None) -> Sequence[float]:
        """Return the range, m, and the bearing, rad, of the nearest return in each sector.

        Examples:
            >>> from types import SimpleNamespace
            >>> message = SimpleNamespace(
            ...     angle_min=0.0, angle_increment=math.pi / 2, range_min=0.1, range_max=3.5,
            ...     ranges=[math.inf, 1.5, 0.02, 2.0],
            ... )
            >>> scan = Scan(sectors=(Sector("left", math.pi / 2, 1.0), Sector("ahead", width=1.0)))
            >>> scan.read(message)
            [1.5, 1.5707963267948966, 3.5, nan]
        """
        mount = mount or self.mount or Mount()
        step, many = message.angle_increment, len(message.ranges) > 1
        if not math.isfinite(message.angle_min + step) or (many and not step):
            return [math.nan] * len(self.fields)
        ranges = np.asarray(message.ranges, dtype=np.float64)
        angles = message.angle_min + message.angle_increment * np.arange(len(ranges))
        least = message.range_min if message.range_min > 0.0 else 0.0
        most = self.reach(message)
        if not 0.0 < most < math.inf:
            most = math.nan

        near = np.isneginf(ranges)
        ranges = np.where(near, least, ranges)
        clear = ranges >= (math.inf if math.isnan(most) else most)
        if self.zero_is_clear:
            clear |= ranges == 0.0
        clear &= ~near
        hit = (ranges >= least) & ~clear & (near | (ranges > 0.0))
        # The length of a ray that meets nothing matters only for its bearing.
        reach = np.where(hit, ranges, 1e3 if math.isnan(most) else most)
        distances, bearings = mount.points(reach, angles)
        if not math.isnan(most):
            distances = np.minimum(distances, most)

        found: list[float] = []
        for sector in self.sectors:
            beside = np.remainder(bearings - sector.center + math.pi, math.tau) - math.pi
            inside = np.abs(beside) <= sector.width / 2.0 + ANGLE_TOLERANCE
            hits = inside & hit
            if hits.any():
                nearest = int(np.argmin(np.where(hits, distances, math.inf)))
                found += [float(distances[nearest]), float(bearings[nearest])]
            elif 0 < inside.sum() <= 2 * (inside & clear).sum():
                found += [float(most), math.nan]
            else:
                found += [math.nan, math.nan]
        return found

    def reach(self, message: Any) -> float:
        """Return the sensor's longest range, m."""
        return float(message.range_max if self.max_range is None else self.max_range)
