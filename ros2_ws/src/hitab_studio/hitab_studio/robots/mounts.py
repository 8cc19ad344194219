"""Mounts of a robot's scanners, from parameters of the agent's node such as `scan.x`, `scan.yaw`.

`hitab_robots` declares these parameters; their prefix is the name of the scanner's topic.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from functools import partial
from typing import Any

from geometry_msgs.msg import Point, Quaternion
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python

from hitab_client import RosLink
from hitab_ros.timing import FOUND_S
from hitab_studio.robots.tf_frames import Matrix, matrix

MOUNT_FIELDS = ("x", "y", "yaw", "upside_down")


class Mounts:
    """Requests the scanners' mounts from an agent's node, without blocking.

    Attributes:
        of: mount of each scanner, by topic; None if the agent has no such parameters.
    """

    def __init__(self, link: RosLink, node: str, scans: Sequence[str]) -> None:
        self.of: dict[str, Matrix | None] = {}
        self._node = link.node
        self._client = link.node.create_client(GetParameters, f"{node}/get_parameters")
        self._scans = scans
        self._next = 0.0

    def look(self) -> None:
        """Send the request, if due."""
        unknown = [topic for topic in self._scans if topic not in self.of]
        if not unknown or time.monotonic() < self._next or not self._client.service_is_ready():
            return
        self._next = time.monotonic() + FOUND_S
        for topic in unknown:
            names = [f"{topic.rpartition('/')[2]}.{field}" for field in MOUNT_FIELDS]
            future = self._client.call_async(GetParameters.Request(names=names))
            future.add_done_callback(partial(self._take, topic))

    def _take(self, topic: str, future: Any) -> None:
        values = [parameter_value_to_python(value) for value in future.result().values]
        if len(values) < len(MOUNT_FIELDS):
            self.of[topic] = None
            return
        x, y, yaw, upside_down = values
        c, s = math.cos(yaw / 2), math.sin(yaw / 2)
        turn = Quaternion(x=c, y=s, w=0.0) if upside_down else Quaternion(z=s, w=c)
        self.of[topic] = matrix(Point(x=x, y=y), turn)

    def close(self) -> None:
        """Stop sending requests."""
        self._node.destroy_client(self._client)
