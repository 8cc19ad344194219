"""Ready-made basic behaviors, features and targets of a `RobotBody`. No ROS here.

A value is named after its sensor and its quantity, such as ``odom.x`` or ``scan.ahead.range``.
Features are required unless said otherwise: a robot whose sensor is silent must not drive on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from hitab_core import BasicBehavior, Feature, FeatureKind, Target, VocabularyError
from hitab_robots.robot import MOTION_MEMORY_S, RobotBody

Point = tuple[float, float]

FULL_SPEED_ANGLE = 0.5
"""Angle to the target, rad, above which a robot turns at full speed."""

SLOW_M = 0.3
"""Distance to the target, m, below which a robot drives more slowly."""

ARRIVED_M = 0.02
"""Distance to the target, m, below which a robot stands still: its direction would be noise."""


def motion(
    name: str, ahead: float = 0.0, turn: float = 0.0, left: float = 0.0, description: str = ""
) -> BasicBehavior:
    """Return a behavior that moves at a constant velocity; by default, it stands still.

    Args:
        name: the behavior's name.
        ahead: m/s.
        turn: rad/s, counter-clockwise.
        left: m/s, of robots that can move sideways.
        description: for people; empty for the velocity in words.

    Examples:
        >>> from hitab_robots import Robot
        >>> body = Robot(())("robot_1")
        >>> motion("Arc", ahead=0.2, turn=0.5).pulse(body)
        >>> (ahead, _, turn), _ = body.act()
        >>> ahead, turn
        (0.2, 0.5)
    """

    def pulse(body: RobotBody) -> None:
        body.drive(ahead, turn, left)

    return BasicBehavior(
        name,
        pulse,
        description=description or _moving(ahead, turn, left),
        stands_still=not (ahead or turn or left),
    )


def _moving(ahead: float, turn: float, left: float) -> str:
    """Return a velocity in words."""
    parts = ((ahead, "m/s ahead"), (left, "m/s to the left"), (turn, "rad/s to the left"))
    return ", ".join(f"{value:g} {unit}" for value, unit in parts if value) or "stands still"


def turn_to(name: str = "TurnTo", turn: float = 0.8, description: str = "") -> BasicBehavior:
    """Return a behavior that turns the robot on the spot to face a target, the shorter way.

    The behavior has no end, and follows a target that moves; a feature such as `facing` shows when
    the robot faces the target.

    Args:
        name: the behavior's name; its parameter is ``X``, as in ``TurnTo(goal)``.
        turn: rad/s, at most.
        description: for people.
    """

    def pulse(body: RobotBody, point: Point) -> None:
        body.drive(0.0, _turning(_bearing(body, point), turn))

    return BasicBehavior(
        name, pulse, parameters=("X",), description=description or "turn on the spot to the target"
    )


def drive_to(
    name: str = "DriveTo", ahead: float = 0.2, turn: float = 0.8, description: str = ""
) -> BasicBehavior:
    """Return a behavior that drives straight to a target, and stands still there.

    The robot first turns to the target and then keeps facing it, by the odometry. The behavior is
    blind to obstacles: train when to perform another one. It has no end; a feature such as
    `distance_to` shows when the robot has arrived.

    Args:
        name: the behavior's name; its parameter is ``X``, as in ``DriveTo(goal)``.
        ahead: m/s, at most.
        turn: rad/s, at most.
        description: for people.

    Examples:
        >>> from hitab_robots import Odometry, Robot
        >>> body = Robot((Odometry(),))("robot_1")
        >>> body.sense([0.1, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], ())
        >>> drive_to().pulse(body, (3.0, 0.0))
        >>> (ahead, _, turn), _ = body.act()
        >>> ahead, turn
        (0.2, 0.0)
    """

    def pulse(body: RobotBody, point: Point) -> None:
        distance, bearing = _distance(body, point), _bearing(body, point)
        if distance <= ARRIVED_M:
            body.drive(0.0)
        elif abs(bearing) > FULL_SPEED_ANGLE:
            body.drive(0.0, _turning(bearing, turn))
        else:  # with NaN, min and max return their first argument, so NaN stays
            body.drive(ahead * min(distance / SLOW_M, 1.0), _turning(bearing, turn))

    return BasicBehavior(
        name, pulse, parameters=("X",), description=description or "drive straight to the target"
    )


def _distance(body: RobotBody, point: Point) -> float:
    """Return the distance of a point from the robot's center, m."""
    x, y, _ = body.place
    return math.hypot(point[0] - x, point[1] - y)


def _bearing(body: RobotBody, point: Point) -> float:
    """Return the direction of a point, rad from ahead, positive left."""
    x, y, heading = body.place
    angle = math.atan2(point[1] - y, point[0] - x) - heading
    return math.remainder(angle, math.tau) if math.isfinite(angle) else math.nan


def _turning(bearing: float, turn: float) -> float:
    """Return the turn rate for a remaining angle, rad/s: slower for small ones; NaN stays NaN."""
    return turn * max(min(bearing / FULL_SPEED_ANGLE, 1.0), -1.0)


def reading(name: str, value: str, *, required: bool = True, **more: Any) -> Feature:
    """Return a feature that is one of the robot's values, such as ``imu.pitch``.

    Args:
        name: the feature's name.
        value: the name of the value.
        required: whether the agent must not decide without a value.
        more: further arguments of `Feature`, such as kind and unit.
    """
    more.setdefault("description", f"the value {value}")
    return Feature(name, ValueOf(value), required=required, **more)


@dataclass(frozen=True)
class ValueOf:
    """Reads a value of the robot, by its name."""

    name: str

    def __call__(self, body: RobotBody) -> float:
        """Return the value."""
        return body[self.name]


def nearest_range(name: str, sector: str, *, required: bool = True) -> Feature:
    """Return the distance to the nearest thing in a sector, m; the maximum if there is nothing.

    Args:
        name: the feature's name.
        sector: a sector of a scanner, such as ``scan.ahead``.
        required: whether the agent must not decide without a value.

    Examples:
        >>> from hitab_robots import Robot, Scan, Sector
        >>> robot = Robot((Scan(sectors=(Sector("ahead", width=0.5),)),))
        >>> body = robot("robot_1")
        >>> body.sense([0.1, 0.8, -0.2], ())
        >>> nearest_range("RangeAhead", "scan.ahead").read(body)
        0.8
    """
    nearest = f"distance to the nearest thing in {sector}"
    return reading(name, f"{sector}.range", required=required, unit="m", description=nearest)


def nearest_bearing(name: str, sector: str, *, required: bool = False) -> Feature:
    """Return the bearing of the nearest thing in a sector, rad; no value if there is nothing.

    Args:
        name: the feature's name.
        sector: a sector of a scanner, such as ``scan.around``.
        required: whether the agent must not decide without a value.
    """
    return reading(
        name,
        f"{sector}.bearing",
        required=required,
        kind=FeatureKind.TOROIDAL,
        unit="rad",
        description=f"direction of the nearest thing in {sector}; 0: ahead",
    )


def distance_to(name: str = "DistanceTo", *, required: bool = True) -> Feature:
    """Return the distance from the robot's center to a target, m."""
    return Feature(
        name,
        _distance,
        parameters=("X",),
        unit="m",
        required=required,
        description="distance to the target",
    )


def heading_to(name: str = "HeadingTo", *, required: bool = True) -> Feature:
    """Return the direction of a target relative to the robot, rad: 0 is ahead, positive left.

    Examples:
        >>> from hitab_robots import Odometry, Robot
        >>> body = Robot((Odometry(),))("robot_1")
        >>> body.sense([0.1, 1.0, 0.0, math.pi / 2, 0.0, 0.0, 0.0], ())
        >>> heading_to().read(body, (0.0, 0.0))
        1.5707963267948966
    """
    return Feature(
        name,
        _bearing,
        FeatureKind.TOROIDAL,
        parameters=("X",),
        unit="rad",
        required=required,
        description="direction of the target; 0: ahead",
    )


def facing(
    name: str = "Facing", within: float = math.radians(10.0), *, required: bool = True
) -> Feature:
    """Return whether the robot faces a target.

    Prefer this feature to `heading_to`: one command by an angle is learned for that exact angle,
    which a real robot never meets again.

    Args:
        name: the feature's name.
        within: largest angle to either side, rad.
        required: whether the agent must not decide without a value.

    Raises:
        VocabularyError: if ``within`` is not between 0 and half a turn.
    """
    if not 0.0 < within < math.pi:
        raise VocabularyError(
            f'feature "{name}" is true within {within:g} rad; it must be between 0 and pi'
        )
    about = f"the robot faces the target, within {math.degrees(within):.0f} deg"
    return _within(name, _bearing, within, required, about)


def near(name: str = "Near", within: float = 0.2, *, required: bool = True) -> Feature:
    """Return whether the robot's center is near a target.

    Prefer this feature to `distance_to`: a command at the target is learned for distances up to
    the present one, which the robot may not reach again.

    Args:
        name: the feature's name.
        within: largest distance, m.
        required: whether the agent must not decide without a value.
    """
    return _within(name, _distance, within, required, f"the target is within {within:g} m")


def _within(
    name: str,
    measure: Callable[[RobotBody, Point], float],
    within: float,
    required: bool,
    description: str,
) -> Feature:
    """Return a feature: whether the magnitude of a measurement is at most a limit."""

    def read(body: RobotBody, point: Point) -> float:
        measured = measure(body, point)
        return measured if math.isnan(measured) else float(abs(measured) <= within)

    return Feature(
        name,
        read,
        FeatureKind.BOOLEAN,
        parameters=("X",),
        required=required,
        description=description,
    )


def stuck(name: str = "Stuck", seconds: float = 2.0, fraction: float = 0.2) -> Feature:
    """Return whether the robot was commanded to move for a while and did not.

    The odometry measures the motion, so a robot whose wheels spin on the spot seems to move.

    Args:
        name: the feature's name.
        seconds: how long the robot must have been commanded to move.
        fraction: fraction of the commanded way or turn; a robot that moves less is stuck.

    Raises:
        VocabularyError: if ``seconds`` exceeds a body's memory.
    """
    if not 0.0 < seconds <= MOTION_MEMORY_S:
        raise VocabularyError(
            f'feature "{name}" looks back {seconds:g} s; it must be up to {MOTION_MEMORY_S:g} s'
        )

    def read(body: RobotBody) -> float:
        if any(map(math.isnan, body.place)):
            return math.nan
        moved = body.moved(seconds)
        if moved is None:
            return 0.0
        drives = moved.commanded_way > 0.0 and moved.way >= fraction * moved.commanded_way
        turns = moved.commanded_turn > 0.0 and moved.turn >= fraction * moved.commanded_turn
        return float(not (drives or turns))

    return Feature(
        name,
        read,
        FeatureKind.BOOLEAN,
        required=True,
        description=f"the robot was commanded to move for {seconds:g} s and has not",
    )


def battery_low(
    name: str = "BatteryLow", below: float = 0.2, sensor: str = "battery_state"
) -> Feature:
    """Return whether the battery's charge is below a fraction.

    Args:
        name: the feature's name.
        below: the fraction, from 0 to 1.
        sensor: name of the battery sensor.
    """

    def read(body: RobotBody) -> float:
        charge = body[f"{sensor}.percentage"]
        return charge if math.isnan(charge) else float(charge < below)

    low = f"the battery holds less than {below:.0%} of its charge"
    return Feature(name, read, FeatureKind.BOOLEAN, description=low)


def place(name: str, x: float, y: float, description: str = "") -> Target:
    """Return a target that stays where it is, m, in the frame of the odometry."""
    return Target(name, lambda body: (x, y), description)


def nearest_return(name: str, sector: str = "scan.around", description: str = "") -> Target:
    """Return a target at the nearest thing that a scanner sees, in the frame of the odometry.

    Args:
        name: the target's name.
        sector: a sector of a scanner, such as ``scan.around``.
        description: for people.
    """

    def resolve(body: RobotBody) -> Point:
        x, y, heading = body.place
        distance, bearing = body[f"{sector}.range"], body[f"{sector}.bearing"]
        angle = heading + bearing
        return x + distance * math.cos(angle), y + distance * math.sin(angle)

    return Target(name, resolve, description)
