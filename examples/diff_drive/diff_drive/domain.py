"""What a differential-drive robot can do and perceive: the words in which it is trained.

No ROS here. SI units; x points ahead, y left, angles are counter-clockwise (REP 103); positions
are in the frame of the odometry.
"""

from __future__ import annotations

import math

from hitab_core import Domain, Feature, FeatureKind
from hitab_robots import (
    Drive,
    Odometry,
    Robot,
    RobotBody,
    Scan,
    Sector,
    distance_to,
    drive_to,
    facing,
    heading_to,
    motion,
    near,
    nearest_range,
    nearest_return,
    place,
    stuck,
)

HULL = 0.2  # m: radius of the robot
TOUCH = 0.05  # m: what is nearer to the hull than this is being touched

# Wide enough for the hull at half a meter.
AHEAD = Sector("ahead", width=math.radians(30.0))

ROBOT = Robot(
    sensors=(Odometry(), Scan(sectors=(AHEAD, Sector("around")))),
    drive=Drive(max_velocity=(0.5, 0.0, 1.0)),
    needed_to_drive=("scan",),
)


def bumped(body: RobotBody) -> float:
    """Return whether the robot touches something; NaN if it cannot tell."""
    nearest = body["scan.around.range"]
    return nearest if math.isnan(nearest) else float(nearest < HULL + TOUCH)


DOMAIN = Domain.of(
    "diff_drive",
    "2",
    ROBOT,
    behaviors=(
        motion("Forward", ahead=0.5, description="drive straight ahead"),
        motion("TurnLeft", turn=1.0, description="turn on the spot"),
        motion("TurnRight", turn=-1.0, description="turn on the spot"),
        motion("Stop", description="stand still"),
        drive_to("DriveTo", ahead=0.5, turn=1.0),
    ),
    features=(
        nearest_range("RangeAhead", "scan.ahead"),
        distance_to("DistanceTo"),
        heading_to("HeadingTo"),
        facing("Facing"),
        near("Near"),
        Feature("Bumped", bumped, FeatureKind.BOOLEAN, required=True),
        stuck("Stuck"),
    ),
    targets=(
        place("home", 0.0, 0.0, "where the odometry began"),
        place("goal", 1.5, -0.75, "a place in the room"),
        nearest_return("nearest_obstacle", "scan.around", "whatever is nearest now"),
    ),
    link="hitab_robots:RobotLink",
)
