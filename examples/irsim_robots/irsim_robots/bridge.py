"""Puts robots of ir-sim on ROS topics, as the drivers of real robots would; no HiTAB here.

For each robot, in a namespace of its name: ``odom``, ``scan`` and ``collision`` out, ``cmd_vel``
in; and the simulated time on ``/clock``. A robot holds its last velocity, as real bases do::

    python -m irsim_robots.bridge --ros-args -p seed:=1 -p real_time_factor:=2.0
"""

from __future__ import annotations

import io
import math
import os
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import redirect_stdout, suppress
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
import yaml
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import Odometry
from rcl_interfaces.msg import SetParametersResult
from rclpy._rclpy_pybind11 import RCLError
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool

from irsim_robots.room import room

MISSING = (
    "ir-sim cannot be imported ({}); install what "
    "examples/irsim_robots/requirements.txt lists and put its folder into PYTHONPATH, as "
    "docs/irsim.md shows"
)
NS = 1_000_000_000
DRIVEN_NS = NS // 2
"""A robot is driven if it has been commanded within this simulated time, ns."""


def simulation(description: dict[str, Any]) -> Any:
    """Return ir-sim's environment of a description, without a window.

    Raises:
        SystemExit: if ir-sim is not installed.
    """
    os.environ.setdefault("MPLBACKEND", "Agg")  # else it tries windows, one after the other
    try:
        with redirect_stdout(io.StringIO()):  # else it names each window that it cannot open
            import irsim
    except ImportError as error:
        raise SystemExit(MISSING.format(error)) from error
    with tempfile.TemporaryDirectory() as folder:  # it reads descriptions from files only
        path = Path(folder) / "room.yaml"
        path.write_text(yaml.safe_dump(description), encoding="utf-8")
        return irsim.make(str(path), headless=True, log_level="ERROR")


def as_time(nanoseconds: int) -> Time:
    """Return a time as a message."""
    return Time(sec=nanoseconds // NS, nanosec=nanoseconds % NS)


def odometry_of(body: Any, name: str, stamp: Time) -> Odometry:
    """Return where one of ir-sim's robots is, and how it moves, as a message."""
    x, y, heading = (float(number) for number in body.state[:3, 0])
    speed = [float(number) for number in body.velocity[:2, 0]]
    odometry = Odometry(child_frame_id=f"{name}/base_link")
    odometry.header.stamp = stamp
    odometry.header.frame_id = f"{name}/odom"
    odometry.pose.pose.position.x, odometry.pose.pose.position.y = x, y
    odometry.pose.pose.orientation.z = math.sin(heading / 2.0)
    odometry.pose.pose.orientation.w = math.cos(heading / 2.0)
    odometry.twist.twist.linear.x, odometry.twist.twist.angular.z = speed
    return odometry


def scan_of(body: Any, name: str, stamp: Time) -> LaserScan:
    """Return what the scanner of one of ir-sim's robots sees, as a message."""
    scan = body.get_lidar_scan()
    # REP 117: infinity where nothing returns, minus infinity where it is too near.
    distances = np.asarray(scan["ranges"], dtype=np.float32)
    missed = np.where(distances <= scan["range_min"], -np.inf, np.inf)
    ranges = np.where(scan["valid"], distances, missed).astype(np.float32)
    message = LaserScan(
        angle_min=float(scan["angle_min"]),
        angle_max=float(scan["angle_max"]),
        angle_increment=float(scan["angle_increment"]),
        range_min=float(scan["range_min"]),
        range_max=float(scan["range_max"]),
        ranges=ranges.tolist(),
    )
    message.header.stamp = stamp
    message.header.frame_id = f"{name}/scanner"
    return message


class Base:
    """One robot on topics.

    Attributes:
        velocity: the last one commanded, m/s and rad/s.
        answered: the stamp of that command, ns; only if it has one.
    """

    def __init__(self, node: Node, name: str, body: Any, *, stamped: bool) -> None:
        self.name = name
        self.body = body
        self.velocity = (0.0, 0.0)
        self.answered = 0
        self._odometry = node.create_publisher(Odometry, f"{name}/odom", 10)
        self._scan = node.create_publisher(LaserScan, f"{name}/scan", qos_profile_sensor_data)
        self._collision = node.create_publisher(Bool, f"{name}/collision", 10)
        kind, obey = (TwistStamped, self._obey_stamped) if stamped else (Twist, self._obey)
        node.create_subscription(kind, f"{name}/cmd_vel", obey, QoSProfile(depth=10))

    def _obey(self, twist: Twist) -> None:
        velocity = twist.linear.x, twist.angular.z
        if all(map(math.isfinite, velocity)):
            self.velocity = velocity

    def _obey_stamped(self, command: TwistStamped) -> None:
        self._obey(command.twist)
        self.answered = command.header.stamp.sec * NS + command.header.stamp.nanosec

    def tell(self, stamp: Time) -> None:
        """Publish where the robot is, what it sees and whether it has collided."""
        self._odometry.publish(odometry_of(self.body, self.name, stamp))
        self._scan.publish(scan_of(self.body, self.name, stamp))
        self._collision.publish(Bool(data=bool(self.body.collision)))


class Bridge(Node):
    """Steps the simulation and publishes each state.

    Its parameters: ``seed`` of the room; how many ``robots``, called robot_1 and so on; ``step``
    of the simulation, s; ``scanner_yaw``, which way the scanners face, rad; whether the bases take
    TwistStamped (``enable_stamped_cmd_vel``); and ``real_time_factor``, which can be set while it
    runs. With ``lockstep`` a step waits for each robot that is driven to be commanded at the
    present time, by the stamp of its velocity, but for no longer than ``patience``, s: then none
    decides too late, however busy the computer is, and the factor is the most; 0: as fast as they
    decide.
    """

    def __init__(self) -> None:
        super().__init__("irsim")

        def parameter(name: str, default: Any) -> Any:
            return self.declare_parameter(name, default).value

        stamped = parameter("enable_stamped_cmd_vel", False)
        self._lockstep = parameter("lockstep", False)
        self._factor = parameter("real_time_factor", 1.0)
        self._patience = parameter("patience", 1.0)
        step = parameter("step", 0.1)
        count = parameter("robots", 2)
        if step <= 0.0:
            raise SystemExit("step must be above 0")
        if self._lockstep and not stamped:
            raise SystemExit("lockstep needs enable_stamped_cmd_vel: true")
        if wrong := self._wrong(self._factor):
            raise SystemExit(wrong)
        self._step_ns = round(step * NS)
        self._now_ns = 0
        self._world = simulation(
            room(parameter("seed", 1), count, step, parameter("scanner_yaw", 0.0))
        )
        self.bases = [
            Base(self, f"robot_{i + 1}", body, stamped=stamped)
            for i, body in enumerate(self._world.robot_list)
        ]
        self._clock_topic = self.create_publisher(Clock, "/clock", 10)
        self.add_on_set_parameters_callback(self._set)

    def _wrong(self, factor: float) -> str:
        """Return what is wrong with a real-time factor; empty: nothing."""
        if factor < 0.0:
            return "real_time_factor must be 0 or above"
        if factor == 0.0 and not self._lockstep:
            return "real_time_factor 0 needs lockstep: true"
        return ""

    def _set(self, parameters: list[Parameter]) -> SetParametersResult:
        for parameter in parameters:
            if parameter.name != "real_time_factor":
                reason = f"{parameter.name} cannot change while the simulation runs"
                return SetParametersResult(successful=False, reason=reason)
            if wrong := self._wrong(parameter.value):
                return SetParametersResult(successful=False, reason=wrong)
            self._factor = parameter.value
        return SetParametersResult(successful=True)

    def run(self, wait: Callable[[float], None]) -> None:
        """Step until ROS ends.

        Args:
            wait: lets callbacks run until one has, for at most some seconds.
        """
        due = time.monotonic()
        while rclpy.ok():
            self._now_ns += self._step_ns
            self._world.step([np.array([base.velocity]).T for base in self.bases])
            stamp = as_time(self._now_ns)
            for base in self.bases:
                base.tell(stamp)
            self._clock_topic.publish(Clock(clock=stamp))
            due = self._next_due(due)
            latest = time.monotonic() + float(self._patience)
            while rclpy.ok():
                now = time.monotonic()
                until = latest if self._waits() and latest > due else due
                if now >= until:
                    break
                wait(until - now)

    def _next_due(self, due: float) -> float:
        """Return when the next step begins at the earliest."""
        now = time.monotonic()
        driven = any(self._now_ns - base.answered < DRIVEN_NS for base in self.bases)
        if self._factor == 0.0 and driven:
            return now
        # What is late is not made up for: the robots would see time leap.
        return max(due + self._step_ns / NS / (float(self._factor) or 1.0), now)

    def _waits(self) -> bool:
        """Return whether a robot that is driven has not been commanded in this step."""
        ages = [self._now_ns - base.answered for base in self.bases]
        return self._lockstep and any(0 < age < DRIVEN_NS for age in ages)


def main() -> None:
    """Run until told to stop."""
    rclpy.init()
    try:
        node = Bridge()
        executor = EventsExecutor()
        executor.add_node(node)
        node.run(lambda seconds: executor.spin_once(timeout_sec=seconds))
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    except RCLError:
        if rclpy.ok():
            raise  # otherwise the node was stopped while it published
    finally:
        with suppress(RCLError):
            rclpy.try_shutdown()


if __name__ == "__main__":
    sys.exit(main())
