"""A robot with standard sensors and a drive, and the body that behaviors act on. No ROS here."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise

from hitab_core import FeatureValueError, VocabularyError, quantity, some, unknown
from hitab_robots.relay.velocity import NO_VELOCITY, Drive, Velocity, is_velocity
from hitab_robots.sensors import Sensor

MOTION_MEMORY_S = 10.0
"""How far back a body remembers its motion, s."""

TIME_LABEL = "time"
"""The first value of each percept: its time, s."""


@dataclass(frozen=True)
class Robot:
    """The parts of a robot, as plain data; a domain makes its bodies with it.

    The percept is the time in s and then the values of the sensors, in order; the action is
    ``[ahead, left, turn]`` in m/s, m/s and rad/s, or empty if no behavior drives the robot.

    Attributes:
        sensors: each with a name of its own.
        drive: limits of its velocity, and which message it takes.
        odometry: name of the sensor for the robot's pose.
        needed_to_drive: sensors, such as ``scan``, or single values, such as ``scan.ahead.range``,
            without which the robot does not drive, whatever behavior it performs.
        body: class of the bodies, derived from `RobotBody`, if behaviors or features need memory;
            None for `RobotBody` itself.

    Examples:
        >>> from hitab_robots import Odometry
        >>> robot = Robot((Odometry(),))
        >>> body = robot("robot_1")
        >>> body.sense([0.1, 1.0, 2.0, 0.0, 0.5, 0.0, 0.0], ())
        >>> body["odom.y"]
        2.0
    """

    sensors: tuple[Sensor, ...]
    drive: Drive = field(default_factory=Drive)
    odometry: str = "odom"
    needed_to_drive: tuple[str, ...] = ()
    body: type[RobotBody] | None = None

    def __post_init__(self) -> None:
        names = [sensor.name for sensor in self.sensors]
        for name in names:
            if names.count(name) > 1 or name == TIME_LABEL:
                raise VocabularyError(
                    f'a second sensor "{name}" of a robot; give it another `name`, and the topic '
                    "as `topic`"
                )
        for name, places in self.needed.items():
            if not places:
                there = {*names, *self.values}
                raise VocabularyError(unknown("value", name, there, " in `needed_to_drive`"))

    def __call__(self, name: str) -> RobotBody:
        """Return the body of one agent."""
        return (self.body or RobotBody)(self)

    @cached_property
    def values(self) -> tuple[str, ...]:
        """The names of a percept's values."""
        return (TIME_LABEL, *(value for sensor in self.sensors for value in sensor.values))

    @cached_property
    def index(self) -> dict[str, int]:
        """The index of each value in a percept, by name."""
        return {name: i for i, name in enumerate(self.values)}

    @cached_property
    def needed(self) -> dict[str, tuple[int, ...]]:
        """The indices of the values of each entry of ``needed_to_drive``, by name."""
        return {
            name: tuple(i for value, i in self.index.items() if f"{value}.".startswith(f"{name}."))
            for name in self.needed_to_drive
        }


@dataclass(frozen=True, slots=True)
class _PastPose:
    """A past pose of a robot, and the velocity that was commanded until then."""

    time: float
    x: float
    y: float
    heading: float
    commanded: Velocity


@dataclass(slots=True)
class Motion:
    """The commanded and the measured motion of a robot: length of the way, m, and turn, rad."""

    commanded_way: float = 0.0
    commanded_turn: float = 0.0
    way: float = 0.0
    turn: float = 0.0


class RobotBody:
    """The body of one robot: its percept, and its next motion.

    Attributes:
        robot: the robot's sensors and drive.
        velocity: the velocity until the next percept; None if no behavior drives the robot.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.velocity: Velocity | None = None
        self._values: Sequence[float] = (math.nan,) * len(robot.values)
        self._past: deque[_PastPose] = deque()

    def __getitem__(self, name: str) -> float:
        """Return a value by name, such as ``odom.x``; NaN if it is unknown now.

        Raises:
            VocabularyError: if the robot has no such value.
        """
        index = self.robot.index.get(name)
        if index is None:
            raise VocabularyError(unknown("value", name, self.robot.index, " of the robot"))
        return self._values[index]

    def sense(self, values: Sequence[float], heard: Sequence[str]) -> None:
        """Take a percept, and reset the velocity: no behavior drives the robot yet."""
        if len(values) != len(self.robot.values):
            raise VocabularyError(
                f"a percept has {quantity(len(values), 'value')} and this robot "
                f"{len(self.robot.values)}; both must come from one declaration"
            )
        self._values = values
        self._remember()
        self.velocity = None

    def act(self) -> tuple[Sequence[float], str]:
        """Return the action, and an empty message: robots say nothing to others."""
        return self.velocity or (), ""

    def drive(self, ahead: float, turn: float = 0.0, left: float = 0.0) -> None:
        """Set the velocity until the next percept, within the limits of the robot's drive.

        Args:
            ahead: m/s, negative backwards.
            turn: rad/s, counter-clockwise.
            left: m/s, for robots that can move sideways.

        Raises:
            FeatureValueError: if a speed is NaN or infinite, such as one computed from a silent
                sensor's values, or if a value that is needed to drive is missing. The robot stops
                until it is re-armed.
        """
        velocity = (ahead, left, turn)
        if not is_velocity(velocity):
            missing = [name for name in self.robot.values if math.isnan(self[name])]
            raise FeatureValueError(
                "its behavior commands a velocity that is not a number; without a value now: "
                f"{some(missing) or 'nothing'}"
            )
        velocity = self.robot.drive.clipped(velocity)
        for name, places in self.robot.needed.items() if velocity != NO_VELOCITY else ():
            if all(math.isnan(self._values[i]) for i in places):
                raise FeatureValueError(
                    f"{name} has no value, and the robot must not drive without it"
                )
        self.velocity = velocity

    @property
    def place(self) -> tuple[float, float, float]:
        """The robot's pose x, y and heading in the frame of its odometry: m, m, rad."""
        name = self.robot.odometry
        return self[f"{name}.x"], self[f"{name}.y"], self[f"{name}.heading"]

    @property
    def position(self) -> tuple[float, float] | None:
        """The robot's position, m, m, for reports to its commander; None if unknown."""
        if f"{self.robot.odometry}.x" not in self.robot.index:
            return None
        x, y, _ = self.place
        return None if math.isnan(x) or math.isnan(y) else (x, y)

    def _remember(self) -> None:
        if f"{self.robot.odometry}.x" not in self.robot.index:
            return
        time, past = self._values[0], self._past
        if past and not past[-1].time < time <= past[-1].time + 1.0:
            past.clear()  # the robot was not driven meanwhile, or the clock was set
        past.append(_PastPose(time, *self.place, self.velocity or NO_VELOCITY))
        while time - past[0].time > MOTION_MEMORY_S:
            past.popleft()

    def moved(self, seconds: float) -> Motion | None:
        """Return how far the robot was recently commanded to move, and how far it moved.

        Args:
            seconds: how far to look back, at most `MOTION_MEMORY_S`.

        Returns:
            The motion; None if the robot was not commanded to move during all of that time, or its
            memory is shorter.
        """
        now = self._values[0]
        recent = [moment for moment in self._past if moment.time >= now - seconds - 1e-9]
        if not recent or now - self._past[0].time < seconds - 1e-9:
            return None
        motion = Motion()
        for before, after in pairwise(recent):
            if after.commanded == NO_VELOCITY:
                return None
            step = after.time - before.time
            motion.commanded_way += math.hypot(after.commanded[0], after.commanded[1]) * step
            motion.commanded_turn += abs(after.commanded[2]) * step
            motion.way += math.hypot(after.x - before.x, after.y - before.y)
            motion.turn += abs(math.remainder(after.heading - before.heading, math.tau))
        return motion if len(recent) > 1 else None
