"""A TurtleBot 3 Burger: what it can do and perceive, as words in which it is trained.

SI units; x points ahead, y left, angles are counter-clockwise (REP 103).
"""

from math import radians

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
    nearest_bearing,
    nearest_range,
    place,
    stuck,
)

SECTORS = (Sector("ahead", width=radians(60.0)), Sector("front", width=radians(180.0)))

ROBOT = Robot(
    # Its scanner's driver writes 0.0 where there is nothing to see.
    sensors=(Odometry(), Scan(sectors=SECTORS, max_range=3.5, zero_is_clear=True)),
    drive=Drive(max_velocity=(0.22, 0.0, 2.0)),
    needed_to_drive=("scan",),
)

DOMAIN = Domain.of(
    "turtlebot",
    "1",
    ROBOT,
    behaviors=(
        motion("Forward", ahead=0.2, description="drive straight ahead"),
        motion("TurnLeft", turn=0.8, description="turn on the spot"),
        motion("TurnRight", turn=-0.8, description="turn on the spot"),
        motion("Stop", description="stand still"),
    ),
    features=(
        nearest_range("RangeAhead", "scan.ahead"),
        nearest_bearing("BearingInFront", "scan.front", required=False),
        distance_to("DistanceTo"),
        heading_to("HeadingTo"),
        stuck("Stuck"),
    ),
    targets=(
        place("dock", 0.0, 0.0, "where the odometry began"),
        place("door", 1.5, -0.5, "a place in the room"),
    ),
    link="hitab_robots:RobotLink",
)
