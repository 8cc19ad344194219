"""What a differential-drive robot can do and perceive: the vocabulary in which it is trained.

No ROS here: a body can be tested, and trained in a simulation, without a robot. SI units; x points
ahead, y left, angles are counter-clockwise (REP 103); positions are in the frame of the odometry.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from hitab_core import BasicBehavior, Domain, Feature, FeatureKind, Target

SPEED = 0.5  # m/s
TURN_RATE = 1.0  # rad/s
HULL = 0.2  # m: radius of the robot
TOUCH = 0.05  # m: what is nearer to the hull than this is being touched

HOME = (0.0, 0.0)
GOAL = (1.5, -0.75)

Point = tuple[float, float]


class DiffDriveBody:
    """What one robot perceives now and does next.

    The percept is ``[x, y, heading, range_ahead, nearest_range, nearest_bearing]``, NaN where a
    sensor is silent; the action ``[linear, angular]`` in m/s and rad/s.
    """

    def __init__(self, name: str) -> None:
        self.sense([math.nan] * 6, ())

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take a percept. Until a behavior says otherwise, the robot stands still."""
        (
            self.x,
            self.y,
            self.heading,
            self.range_ahead,
            self.nearest_range,
            self.nearest_bearing,
        ) = values
        self.velocity = (0.0, 0.0)

    def act(self) -> tuple[Sequence[float], str]:
        """Return the action; this robot has nothing to say to others."""
        return self.velocity, ""


def forward(body: DiffDriveBody) -> None:
    """Drive straight ahead."""
    body.velocity = (SPEED, 0.0)


def turn_left(body: DiffDriveBody) -> None:
    """Turn on the spot, counter-clockwise."""
    body.velocity = (0.0, TURN_RATE)


def turn_right(body: DiffDriveBody) -> None:
    """Turn on the spot, clockwise."""
    body.velocity = (0.0, -TURN_RATE)


def stop(body: DiffDriveBody) -> None:
    """Stand still."""
    body.velocity = (0.0, 0.0)


def range_ahead(body: DiffDriveBody) -> float:
    """Return how far away the nearest thing ahead is."""
    return body.range_ahead


def distance_to(body: DiffDriveBody, point: Point) -> float:
    """Return the distance from the robot's centre to a point."""
    return math.hypot(point[0] - body.x, point[1] - body.y)


def heading_to(body: DiffDriveBody, point: Point) -> float:
    """Return where a point is, relative to where the robot faces: 0 is ahead, positive left."""
    angle = math.atan2(point[1] - body.y, point[0] - body.x) - body.heading
    return math.remainder(angle, math.tau)


def bumped(body: DiffDriveBody) -> float:
    """Return whether the robot touches something; NaN if it cannot tell."""
    if math.isnan(body.nearest_range):
        return math.nan
    return float(body.nearest_range < HULL + TOUCH)


def nearest_obstacle(body: DiffDriveBody) -> Point:
    """Return where the nearest thing is that the range sensor sees."""
    angle = body.heading + body.nearest_bearing
    return (
        body.x + body.nearest_range * math.cos(angle),
        body.y + body.nearest_range * math.sin(angle),
    )


DOMAIN = Domain.of(
    "diff_drive",
    "1",
    DiffDriveBody,
    behaviors=(
        BasicBehavior("Forward", forward, description="drive straight ahead"),
        BasicBehavior("TurnLeft", turn_left, description="turn on the spot"),
        BasicBehavior("TurnRight", turn_right, description="turn on the spot"),
        BasicBehavior("Stop", stop, description="stand still"),
    ),
    features=(
        # Required: a robot whose sensor is silent must not drive on by what is usual.
        Feature("RangeAhead", range_ahead, unit="m", required=True),
        Feature("DistanceTo", distance_to, parameters=("X",), unit="m", required=True),
        Feature(
            "HeadingTo",
            heading_to,
            FeatureKind.TOROIDAL,
            parameters=("X",),
            unit="rad",
            required=True,
        ),
        Feature("Bumped", bumped, FeatureKind.BOOLEAN, required=True),
    ),
    targets=(
        Target("home", lambda body: HOME, "where the odometry began"),
        Target("goal", lambda body: GOAL, "a place in the room"),
        Target("nearest_obstacle", nearest_obstacle, "whatever is nearest now"),
    ),
    link="diff_drive.link:DiffDriveLink",
)
