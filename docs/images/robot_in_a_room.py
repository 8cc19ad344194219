"""What a robot in a simulated room has besides odometry and scanner: a camera and a map.

For the picture of the studio with a robot: where `diff_drive.simulated_robot` is, this draws what
a camera on it would see, from the same rays as its scanner, and maps the room once.
"""

from __future__ import annotations

import array
import io
import math

import numpy as np
import rclpy
from diff_drive.simulated_robot import BOTTOM, LEFT, RIGHT, TOP, distance
from nav_msgs.msg import OccupancyGrid, Odometry
from PIL import Image
from rclpy.executors import ExternalShutdownException
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import CompressedImage

WIDTH, HEIGHT = 320, 240
FOCAL = 260.0  # px
EYE, CEILING = 0.25, 0.5  # m: height of the camera and, above it, of the walls' upper edge
CELL, EDGE = 0.05, 0.15  # m
FLOOR, WALL, SKY = (186, 180, 168), (232, 226, 214), (205, 216, 228)
PERIOD = 0.2  # s


def view(x: float, y: float, heading: float) -> Image.Image:
    """Return what a camera there sees, column by column."""
    picture = np.empty((HEIGHT, WIDTH, 3), np.uint8)
    rows = np.arange(HEIGHT) - HEIGHT / 2
    for column in range(WIDTH):
        angle = math.atan2(WIDTH / 2 - column, FOCAL)
        away = distance(x, y, heading + angle)
        depth = max(away * math.cos(angle), 0.05)
        side = math.hypot(
            x + away * math.cos(heading + angle), y + away * math.sin(heading + angle)
        )
        shade = (0.72 + 0.28 * math.cos(3.0 * side)) / (1.0 + 0.18 * away)
        up, down = rows < -FOCAL * CEILING / depth, rows > FOCAL * EYE / depth
        picture[:, column] = (np.array(WALL) * shade).astype(np.uint8)
        picture[up, column], picture[down, column] = SKY, FLOOR
    return Image.fromarray(picture)


def room() -> OccupancyGrid:
    """Return the map: what a robot would draw that has been everywhere."""
    grid = OccupancyGrid()
    grid.header.frame_id = "odom"
    grid.info.resolution = CELL
    left, bottom = LEFT - 2 * EDGE, BOTTOM - 2 * EDGE
    grid.info.width = round((RIGHT - LEFT + 4 * EDGE) / CELL)
    grid.info.height = round((TOP - BOTTOM + 4 * EDGE) / CELL)
    grid.info.origin.position.x, grid.info.origin.position.y = left, bottom
    grid.info.origin.orientation.w = 1.0
    cells = np.full((grid.info.height, grid.info.width), -1, np.int8)
    for angle in np.arange(0.0, math.tau, 0.002):
        for x0, y0 in ((0.0, 0.0), (1.5, 0.5), (-1.2, 1.3), (-1.3, -1.0)):
            away = distance(x0, y0, angle)
            steps = np.append(np.arange(0.0, away, CELL / 2), away + CELL / 2)
            columns = ((x0 + steps * math.cos(angle) - left) / CELL).astype(int)
            rows = ((y0 + steps * math.sin(angle) - bottom) / CELL).astype(int)
            free = cells[rows[:-1], columns[:-1]]
            cells[rows[:-1], columns[:-1]] = np.where(free == 100, 100, 0)
            cells[rows[-1], columns[-1]] = 100
    grid.data = array.array("b", cells.tobytes())
    return grid


class RoomViews(Node):
    """Publishes the camera's picture and the map."""

    def __init__(self) -> None:
        super().__init__("room_views")
        self.pose = (0.0, 0.0, 0.0)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.map = self.create_publisher(OccupancyGrid, "/map", latched)
        self.map.publish(room())
        self.camera = self.create_publisher(CompressedImage, "camera/image_raw/compressed", 1)
        self.create_subscription(Odometry, "odom", self.move, qos_profile_sensor_data)
        self.create_timer(PERIOD, self.film)

    def move(self, odometry: Odometry) -> None:
        """Be where the robot is."""
        pose = odometry.pose.pose
        turn = 2.0 * math.atan2(pose.orientation.z, pose.orientation.w)
        self.pose = (pose.position.x, pose.position.y, turn)

    def film(self) -> None:
        """Publish a picture."""
        out = io.BytesIO()
        view(*self.pose).save(out, "JPEG")
        picture = CompressedImage(format="jpeg", data=array.array("B", out.getvalue()))
        picture.header.stamp = self.get_clock().now().to_msg()
        self.camera.publish(picture)


def main() -> None:
    """Run until stopped."""
    rclpy.init()
    try:
        rclpy.spin(RoomViews())
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        rclpy.try_shutdown()


if __name__ == "__main__":
    main()
