"""The link of an agent to a robot with standard messages: sensors in, velocity out.

A domain whose body is a `hitab_robots.robot.Robot` names it as its link:
``Domain.of(..., link="hitab_robots:RobotLink")``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

from geometry_msgs.msg import TwistStamped
from hitab_msgs.msg import Percept
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.qos import QoSProfile, qos_profile_sensor_data

from hitab_agent import AgentNode, OnPercept
from hitab_core import HitabError
from hitab_robots import wiring
from hitab_robots.frames import mounts_of_tf
from hitab_robots.freshness import CLOCK_TOLERANCE_S, Freshness
from hitab_robots.mount import Mount
from hitab_robots.relay.relay_process import RelayProcess
from hitab_robots.relay.relay_watch import RelayWatch
from hitab_robots.relay.velocity import REST_S
from hitab_robots.robot import Robot
from hitab_robots.sensors import Sensor
from hitab_robots.settings import (
    AGENT_VELOCITY_TOPIC,
    ODOMETRY_TOPIC,
    RelaySettings,
    declare,
    declare_number,
)
from hitab_ros import EmergencySwitch, names, steady_timer
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.timing import FOUND_S, HEARTBEAT_S

ODOMETRY_TYPE = "nav_msgs/msg/Odometry"

NEWEST = QoSProfile(depth=1)
"""QoS of velocities: reliable, and only the newest is kept."""


class RobotLink:
    """Ticks the agent at a fixed rate with the last sensor readings, and drives the robot.

    Parameters are ``rate``, Hz; for each sensor its ``patience``, s, and for sensors whose place
    matters ``x``, ``y``, ``yaw`` and ``upside_down``, such as ``scan.yaw``. With ``base_frame``,
    the places come from tf2 instead.

    The velocity goes to the robot's relay (`hitab_robots.relay.velocity_relay`), never to its
    base: the relay stops the robot when the agent cannot, and decides when the robot may act again
    (`hitab_robots.relay.relay_watch`). The link starts the relay and passes its parameters on
    (`hitab_robots.settings`), unless the parameter ``relay`` is false: then a person starts it.
    """

    def __init__(self, node: AgentNode, world: str, on_percept: OnPercept) -> None:
        domain = node.agent.domain
        if not isinstance(domain.body, Robot):
            raise HitabError(
                f'domain "{domain.name}": the link hitab_robots:RobotLink needs a body made by '
                "hitab_robots.Robot(sensors=...); give the domain one, or a link of its own"
            )
        self._node = node
        self._on_percept = on_percept
        self._faults = node.guard.faults
        self._clock = node.get_clock()
        self._checks_from = time.monotonic() + FOUND_S
        rate = declare_number(node, "rate", 10.0)
        mounts = _mounts_of_tf(node)
        self._sensors = [_SensorInput(node, sensor, mounts) for sensor in domain.body.sensors]
        self._velocities = node.create_publisher(TwistStamped, AGENT_VELOCITY_TOPIC, NEWEST)
        settings = RelaySettings.declare(node, domain.body.drive)
        self._relay = None
        if declare(node, "relay", True):
            odometry = (s.topic_name for s in domain.body.sensors if s.message == ODOMETRY_TYPE)
            self._relay = RelayProcess(node, settings, next(odometry, ODOMETRY_TOPIC))
        node.stop = RelayWatch(node, self._relay)
        # The more processes remember a stop, the more surely it reaches a relay found late.
        self._switch = EmergencySwitch(node, hands_on=True)
        self._rest_until = self._now()
        self._cycle = 0
        node.create_timer(1.0 / rate, self._tick)
        steady_timer(node, HEARTBEAT_S, self._look_for_faults)  # simulated time may stand still

    def _now(self) -> float:
        return float(self._clock.now().nanoseconds) * 1e-9

    def _tick(self) -> None:
        now = self._clock.now()
        seconds = self._now()
        self._cycle += 1
        values = [seconds]
        for sensor in self._sensors:
            values += sensor.freshness.values(seconds)
        percept = Percept(
            stamp=now.to_msg(), sequence=self._cycle, cycle=self._cycle, values=values
        )
        action, _ = self._on_percept(percept)
        self._drive(action, seconds)

    def _drive(self, action: Any, seconds: float) -> None:
        """Send a velocity; without one, send zeros for a moment, then nothing."""
        if action:
            self._rest_until = seconds + REST_S
        elif not self._rest_until - REST_S <= seconds <= self._rest_until:
            return
        velocity = TwistStamped()
        velocity.header.stamp = self._clock.now().to_msg()
        velocity.header.frame_id = "base_link"
        if action:
            twist = velocity.twist
            twist.linear.x, twist.linear.y, twist.angular.z = action
        self._velocities.publish(velocity)

    def _look_for_faults(self) -> None:
        if time.monotonic() < self._checks_from:
            return
        for sensor in self._sensors:
            self._faults.set(f"sensor {sensor.name}", sensor.trouble(self._now()))
        reach = {sensor.name: sensor.reach for sensor in self._sensors}
        for check in wiring.CHECKS:
            self._faults.set(check.__name__, check(self._node, reach))
        text = ""
        if self._relay is None and self._velocities.get_subscription_count() == 0:
            text = (
                f"nothing passes the velocity on to the robot: no {names.VELOCITY_RELAY} listens "
                f"on {self._velocities.topic_name}; start it with `ros2 run hitab_robots "
                f"{names.VELOCITY_RELAY}` in the agent's namespace, or let the parameter relay "
                "be true"
            )
        self._faults.set("relay", text)

    def close(self) -> None:
        """Bring the robot to rest before the agent ends."""
        self._velocities.publish(TwistStamped())
        self._velocities.wait_for_all_acked(Duration(seconds=0.5))
        if self._relay is not None:
            self._relay.end()


class _SensorInput:
    """The topic of a sensor, and its last reading.

    Attributes:
        name: name of the sensor.
        freshness: the last reading, and its age.
        reach: the longest range of the sensor, m; infinite if it has none or none is known yet.
    """

    def __init__(
        self, node: Node, sensor: Sensor, mounts: Callable[[str], Mount | None] | None
    ) -> None:
        self.name = sensor.name
        self.reach = math.inf
        self._node = node
        self._sensor = sensor
        self._clock = node.get_clock()
        patience = declare_number(node, f"{sensor.name}.patience", sensor.patience)
        simulated = node.get_parameter("use_sim_time").value
        ahead = math.inf if simulated else CLOCK_TOLERANCE_S
        self.freshness = Freshness(len(sensor.fields), patience, ahead)
        self._mounts = mounts if sensor.mount is not None else None
        self._unplaced = ""
        self._mount = sensor.mount
        if self._mount is not None:
            self._mount = _declared_mount(node, sensor.name, self._mount)
        self._subscription = node.create_subscription(
            _message_class(sensor), sensor.topic_name, self._take, qos_profile_sensor_data
        )

    def _take(self, message: Any) -> None:
        mount = self._mount
        self._unplaced = ""
        self.reach = self._sensor.reach(message)
        if self._mounts is not None:
            mount = self._mounts(message.header.frame_id)
            if mount is None:
                self._unplaced = message.header.frame_id or "(none)"
                return
        self.freshness.take(
            self._sensor.read(message, mount),
            seconds_of(message.header.stamp),
            self._clock.now().nanoseconds * 1e-9,
        )

    def trouble(self, now: float) -> str:
        """Return why the sensor has no values, or another fault; empty if there is none."""
        what = f"sensor {self.name}, {self._subscription.topic_name}"
        if self._unplaced:
            return f"{what}: tf2 has no transform from its frame {self._unplaced} to base_frame"
        if self.freshness.trouble:
            return f"{what}: {self.freshness.trouble}; set the clocks of all machines"
        if self.freshness.is_fresh(now):
            return ""
        why = wiring.unheard(self._node, self._subscription.topic_name, self._sensor.message)
        return f"{what}: {why}"


def _message_class(sensor: Sensor) -> Any:
    package, _, name = sensor.message.partition("/msg/")
    try:
        return getattr(import_module(f"{package}.msg"), name)
    except (ImportError, AttributeError) as error:
        raise HitabError(
            f'sensor "{sensor.name}" sends {sensor.message}, which cannot be imported: {error}; '
            f"install the ROS package {package}"
        ) from error


def _mounts_of_tf(node: Node) -> Callable[[str], Mount | None] | None:
    base_frame = declare(node, "base_frame", "")
    return mounts_of_tf(node, base_frame) if base_frame else None


def _declared_mount(node: Node, name: str, mount: Mount) -> Mount:
    x, y, yaw = (float(declare(node, f"{name}.{f}", getattr(mount, f))) for f in ("x", "y", "yaw"))
    return Mount(x, y, yaw, bool(declare(node, f"{name}.upside_down", mount.upside_down)))
