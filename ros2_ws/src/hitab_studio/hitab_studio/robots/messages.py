"""What the messages of a robot say, checked: odometry, scans, maps and pictures.

`read` takes a serialized message, whose length was checked. All functions raise `Refused` if a
message makes no sense.
"""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from nav_msgs.msg import OccupancyGrid, Odometry
from numpy.typing import NDArray
from PIL import Image
from rclpy.serialization import deserialize_message
from sensor_msgs.msg import CompressedImage, LaserScan

from hitab_core import HitabError
from hitab_studio.robots.frames import Matrix, matrix, planar

PICTURE_BYTES = 8_000_000
PICTURE_SIDE = 4096
"""Pixels; a small file may claim more than a browser can hold."""

MAP_CELLS = 16_777_216
MAP_BYTES = MAP_CELLS + 10_000
SCAN_BYTES = 1_000_000
POINTS_MAX = 2000
"""Points of a scan that are shown; of more, each so-many-th."""

NAME_MAX = 256
"""Letters of the name of a frame."""

FARTHEST = 1e5
"""m; what is farther away cannot be shown."""

RANGE_MAX = 200.0
"""m; no scanner of a robot sees farther."""


class Refused(HitabError):
    """A message that cannot be used; the text says why, after the name of its topic."""


@dataclass(frozen=True)
class Placed:
    """A robot's place.

    Attributes:
        frame, child: names of the frames of the odometry and of the robot.
        pose: of the robot in the odometry's frame, in the plane.
    """

    frame: str
    child: str
    pose: Matrix


@dataclass(frozen=True)
class Scanned:
    """The returns of a scan: points in the frame of the scanner, m, shape (n, 2)."""

    frame: str
    points: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Grid:
    """A map.

    Attributes:
        frame: in which it lies.
        resolution: width of a cell, m.
        origin: where its first cell has its corner, in that frame.
        cells: how occupied each is, from 0 to 100, -1 unknown; shape (height, width).
    """

    frame: str
    resolution: float
    origin: Matrix
    cells: NDArray[np.int8]

    @property
    def place(self) -> tuple[float, float, float]:
        """The origin as x, y in m and yaw in rad."""
        x, y = self.origin[:2, 3].tolist()
        return x, y, math.atan2(self.origin[1, 0], self.origin[0, 0])

    def corners(self) -> NDArray[np.float64]:
        """Return its corners in its frame, m, shape (4, 2)."""
        h, w = (self.resolution * side for side in self.cells.shape)
        corners = np.array([(x, y, 0.0, 1.0) for x in (0.0, w) for y in (0.0, h)])
        shown: NDArray[np.float64] = (corners @ self.origin.T)[:, :2]
        return shown


@dataclass(frozen=True)
class Picture:
    """A picture as a browser can show it."""

    media_type: str
    data: bytes


def read(kind: Any, data: bytes) -> Any:
    """Return a message of this class.

    Raises:
        Refused: if it is none.
    """
    try:
        return deserialize_message(data, kind)
    except Exception as error:  # of the middleware, whichever it is
        why = " ".join(str(error).split())[:100]
        raise Refused(f"sends what is no {kind.__name__}: {why}") from None


def _frame(name: str) -> str:
    if len(name) > NAME_MAX:
        raise Refused(f"has a frame whose name has more than {NAME_MAX} letters")
    return name


def stamp_of(message: Any) -> float:
    """Return the stamp of a message, s; 0: it has none."""
    header = getattr(message, "header", None)
    return 0.0 if header is None else header.stamp.sec + 1e-9 * header.stamp.nanosec


def _pose(pose: Any, of: str) -> Matrix:
    place, turn = pose.position, pose.orientation
    numbers = (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
    if not all(abs(number) < FARTHEST for number in numbers):
        raise Refused(f"says that {of} is at {place.x:g}, {place.y:g} m, which is nowhere")
    made = matrix(numbers[:3], numbers[3:])
    if made is None:
        raise Refused(f"does not say which way {of} faces: its orientation is no quaternion")
    return made


def odometry_of(message: Odometry) -> Placed:
    """Return what a `nav_msgs/Odometry` says."""
    pose = planar(_pose(message.pose.pose, "the robot"))
    return Placed(_frame(message.header.frame_id), _frame(message.child_frame_id), pose)


def scan_of(message: LaserScan) -> Scanned:
    """Return the returns of a `sensor_msgs/LaserScan` (REP 117)."""
    first, step, most = message.angle_min, message.angle_increment, message.range_max
    if not (math.isfinite(first) and math.isfinite(step)):
        raise Refused("does not say where its rays point: an angle is not a number")
    ranges = np.asarray(message.ranges, dtype=np.float64)
    every = -(-len(ranges) // POINTS_MAX) or 1
    angles = (first + step * np.arange(len(ranges)))[::every]
    ranges = ranges[::every]
    most = min(most, RANGE_MAX) if most > 0.0 else RANGE_MAX
    with np.errstate(invalid="ignore"):
        hit = (ranges > 0.0) & (ranges >= message.range_min) & (ranges < most)
    ranges, angles = ranges[hit], angles[hit]
    points = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
    return Scanned(_frame(message.header.frame_id), points)


def map_of(message: OccupancyGrid) -> Grid:
    """Return what a `nav_msgs/OccupancyGrid` says."""
    info = message.info
    width, height = info.width, info.height
    if not 0.0 < info.resolution < 1000.0:
        raise Refused(f"has cells of {info.resolution:g} m")
    if not 0 < width * height <= MAP_CELLS:
        raise Refused(f"has {width} x {height} cells; up to {MAP_CELLS} can be shown")
    if len(message.data) != width * height:
        raise Refused(f"says that it has {width} x {height} cells, and has {len(message.data)}")
    cells = np.frombuffer(message.data, np.int8).reshape(height, width)
    origin = _pose(info.origin, "its origin")
    return Grid(_frame(message.header.frame_id), info.resolution, origin, cells)


def picture_of(message: CompressedImage) -> Picture:
    """Return the picture of a `sensor_msgs/CompressedImage`, if browsers show such ones."""
    data = message.data.tobytes()
    try:
        with Image.open(io.BytesIO(data), formats=("JPEG", "PNG")) as image:  # only its header
            media_type, size = Image.MIME[image.format or ""], image.size
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        raise Refused(
            f'is neither JPEG nor PNG; it calls itself "{message.format[:60]}"'
        ) from None
    if max(size) > PICTURE_SIDE:
        raise Refused(
            f"has {size[0]} x {size[1]} pixels; up to {PICTURE_SIDE} x {PICTURE_SIDE} are shown"
        )
    return Picture(media_type, data)
