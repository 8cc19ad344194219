"""What the robots can do and perceive: the words in which they are trained. No ROS here.

SI units; places are in the frame of the odometry, which begins in a corner of the room.
"""

from __future__ import annotations

import math

from hitab_core import Domain
from hitab_robots import (
    Drive,
    Odometry,
    Robot,
    Scan,
    Sector,
    distance_to,
    heading_to,
    motion,
    nearest_range,
    place,
)
from irsim_robots.room import RANGE_MAX, WAYPOINTS

SECTORS = (
    # To both sides as well: robots with the same goal come together side by side.
    Sector("ahead", width=math.radians(190.0)),
    # And farther back on the right: where what the robot has turned away from is until it is past.
    Sector("beside", center=math.radians(-17.5), width=math.radians(225.0)),
)
DOMAIN = Domain.of(
    "irsim",
    "1",
    Robot(
        sensors=(Odometry(), Scan(sectors=SECTORS, max_range=RANGE_MAX)),
        drive=Drive(max_velocity=(0.5, 0.0, 1.5)),
        needed_to_drive=("scan",),
    ),
    behaviors=(
        motion("Forward", ahead=0.3, description="drive straight ahead"),
        motion("TurnLeft", turn=0.6, description="turn on the spot"),
        motion("TurnRight", turn=-0.6, description="turn on the spot"),
    ),
    features=(
        nearest_range("RangeAhead", "scan.ahead"),
        nearest_range("RangeBeside", "scan.beside"),
        distance_to("DistanceTo"),
        heading_to("HeadingTo"),
    ),
    targets=tuple(place(name, x, y) for name, (x, y) in WAYPOINTS.items()),
    link="hitab_robots:RobotLink",
)
