"""Lets a robot act again, as a person does who has looked at it."""

from __future__ import annotations

import time

from hitab_client.errors import SwarmError
from hitab_client.ros_link import RosLink
from hitab_client.stops import Stops

SECONDS = 60.0


def arm(link: RosLink, robot: str) -> None:
    """Re-arm a robot as soon as nothing speaks against it."""
    stops, deadline = Stops(link), time.monotonic() + SECONDS
    while True:
        try:
            return stops.arm(robot, SECONDS)
        except SwarmError:
            assert time.monotonic() < deadline, "it cannot be re-armed"
            link.spin(0.1)
