"""Checked contents of a robot's messages: odometry, scans, maps and pictures.

All functions raise `Refused` if a message is invalid. Scans, maps and pictures are sent to pages
as binary frames that begin with their kind:

    uint32  SCANS, float32 x, y of each point, in the frame of the drawing
    uint32  MAP, float32 x, y, yaw of the origin and width of a cell, then a PNG
    uint32  PICTURE, then a JPEG or PNG
"""

from __future__ import annotations

import io
import math
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from nav_msgs.msg import OccupancyGrid, Odometry
from numpy.typing import NDArray
from PIL import Image
from sensor_msgs.msg import CompressedImage, LaserScan

from hitab_core import HitabError
from hitab_studio.robots.tf_frames import Matrix, applied, in_plane, matrix

SCANS, MAP, PICTURE = 2, 3, 4
NO_SCANS = struct.pack("<I", SCANS)

PICTURE_SIDE = 4096
"""Maximum width and height, pixels; a small file may claim more than a browser can hold."""

MAP_CELLS = 16_777_216
ROBOT_MESSAGE_BYTES_MAX = MAP_CELLS + 10_000
"""Maximum size of a message, bytes; larger ones are refused."""

POINTS_MAX = 2000
"""Maximum number of points shown of a scan; longer scans are thinned out evenly."""

RANGE_MAX = 200.0
"""Maximum range of a scanner, m."""

PNG_COMPRESSION = 1
"""PNG compression level of maps: low, since compressing blocks the server's loop."""

OCCUPIED = 255
UNKNOWN_OPACITY = 36
"""Opacity of unknown cells; free cells are transparent."""


class Refused(HitabError):
    """An invalid message; the text is the reason, to be shown after the topic's name."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A robot's pose in the odometry frame, with the names of this frame and the robot's frame."""

    frame: str
    child: str
    pose: Matrix


@dataclass(frozen=True, eq=False)
class Scanned:
    """The returns of a scan: points in the frame of the scanner, m, shape (n, 2)."""

    frame: str
    points: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Grid:
    """A map: its frame, its corners there, m, shape (4, 2), and the binary frame for pages."""

    frame: str
    corners: NDArray[np.float64]
    drawn: bytes


def _pose(pose: Any, of: str) -> Matrix:
    if (made := matrix(pose.position, pose.orientation)) is None:
        raise Refused(
            f"has no valid position and orientation of {of}: "
            f"{pose.position.x:g}, {pose.position.y:g} m"
        )
    return made


def odometry_of(message: Odometry) -> Placed:
    """Return the pose in a `nav_msgs/Odometry`."""
    pose = _pose(message.pose.pose, "the robot")
    return Placed(message.header.frame_id, message.child_frame_id, pose)


def scan_of(message: LaserScan) -> Scanned:
    """Return the returns of a `sensor_msgs/LaserScan` (REP 117)."""
    first, step, most = message.angle_min, message.angle_increment, message.range_max
    if not (math.isfinite(first) and math.isfinite(step)):
        raise Refused("has no valid directions of its rays: an angle is not a number")
    ranges = np.asarray(message.ranges, dtype=np.float64)
    every = -(-len(ranges) // POINTS_MAX) or 1
    angles = (first + step * np.arange(len(ranges)))[::every]
    ranges = ranges[::every]
    most = min(most, RANGE_MAX) if most > 0.0 else RANGE_MAX
    with np.errstate(invalid="ignore"):
        hit = (ranges > 0.0) & (ranges >= message.range_min) & (ranges < most)
    ranges, angles = ranges[hit], angles[hit]
    points = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles)))
    return Scanned(message.header.frame_id, points)


def map_of(message: OccupancyGrid) -> Grid:
    """Return the grid in a `nav_msgs/OccupancyGrid`."""
    info = message.info
    width, height = info.width, info.height
    if not 0.0 < info.resolution < 1000.0:
        raise Refused(f"has cells of {info.resolution:g} m")
    if not 0 < width * height <= MAP_CELLS:
        raise Refused(f"has {width} x {height} cells; up to {MAP_CELLS} can be shown")
    if len(message.data) != width * height:
        raise Refused(f"announces {width} x {height} cells and has {len(message.data)}")
    origin = _pose(info.origin, "its origin")
    w, h = width * info.resolution, height * info.resolution
    corners = applied(origin, np.array([(x, y) for x in (0.0, w) for y in (0.0, h)]))
    place = struct.pack("<I4f", MAP, *in_plane(origin), info.resolution)
    cells = np.frombuffer(message.data, np.uint8).reshape(height, width)
    return Grid(message.header.frame_id, corners, place + _png(cells))


def _png(cells: NDArray[np.uint8]) -> bytes:
    """Return a PNG in which the opacity of a pixel grows with the probability of an obstacle.

    The first row is the farthest in y. The page colors the PNG according to the theme.
    """
    # A palette of opacities turns the cells of the map into pixels without any calculation.
    opacity = np.full(256, UNKNOWN_OPACITY, np.uint8)
    opacity[:101] = np.round(np.linspace(0, OCCUPIED, 101))
    image = Image.fromarray(np.ascontiguousarray(cells[::-1]))
    image.putpalette(bytes(3 * 256))
    png = io.BytesIO()
    image.save(png, "PNG", transparency=opacity.tobytes(), compress_level=PNG_COMPRESSION)
    return png.getvalue()


def picture_of(message: CompressedImage) -> bytes:
    """Return the binary frame of a `sensor_msgs/CompressedImage` in a format of browsers."""
    data = message.data.tobytes()
    try:
        with Image.open(io.BytesIO(data), formats=("JPEG", "PNG")) as image:  # only its header
            size = image.size
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError):
        raise Refused(f'is neither JPEG nor PNG; its format is "{message.format[:60]}"') from None
    if max(size) > PICTURE_SIDE:
        raise Refused(
            f"has {size[0]} x {size[1]} pixels; up to {PICTURE_SIDE} x {PICTURE_SIDE} are shown"
        )
    return struct.pack("<I", PICTURE) + data
