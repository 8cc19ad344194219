"""The relay: passes an agent's velocities on to its robot's base, and stops the robot.

A person who drives the robot by hand does so through the relay too, with precedence over the
agent.

The relay is a process of its own, since it must outlive an agent that dies. The agent's link
starts it, unless the agent's parameter ``relay`` is false. Then start it by hand::

    ros2 run hitab_robots velocity_relay --ros-args -r __ns:=/robot_1
"""

from __future__ import annotations

import json
import math
import os
import signal
import sys
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from hitab_msgs.msg import StopState
from nav_msgs.msg import Odometry
from rclpy.duration import Duration
from rclpy.qos import QoSProfile, qos_profile_sensor_data

from hitab_core import some
from hitab_core.library.durable_files import write_durably
from hitab_robots.bases import Bases, name_of
from hitab_robots.relay.left_goals import LeftGoals
from hitab_robots.relay.process_state import REPLACED_AFTER_S, waits_for_cpu_or_disk
from hitab_robots.relay.velocity import NO_VELOCITY, SILENT_S, Drive, Gate, Velocity
from hitab_robots.settings import (
    AGENT_VELOCITY_TOPIC,
    BASE_TOPIC,
    HEARTBEAT,
    ODOMETRY_TOPIC,
    RelaySettings,
    declare,
)
from hitab_ros import (
    GuardedNode,
    KnownStops,
    Presence,
    Spinner,
    Stop,
    names,
    qos,
    run,
    steady_timer,
)
from hitab_ros.timing import STOP_REPORT_PERIOD_S

STOP_FILE = "emergency_stop.json"

AGENT = "agent"
"""The agent, in the relay's presence and causes."""

SILENCE = "silence"
"""The stop's cause for a silent agent."""

AGENT_HUNG_S = 1.0
"""Silence, s, of an agent on this machine that is suspended or waits; then the robot must be
re-armed."""

STANDSTILL = (0.02, 0.02, 0.05)
"""Largest speeds of a robot that stands still, by its odometry, m/s, m/s and rad/s."""

ZEROS_S = 0.2
"""How long only zeros must have been sent before a robot counts as standing still, s."""

MEASURED_S = 1.0
"""How long a measurement of the odometry counts, s."""


class VelocityRelay(GuardedNode):
    """Sends the base the agent's velocities within limits, and zeros when the robot has to stop.

    A person's velocity on ``cmd_vel_teleop`` takes precedence over the agent's. The robot stops
    while both are silent for longer than `cmd_vel_timeout`. It stops until it is re-armed
    (`hitab_ros.stopping.stop_machine`) after an emergency stop, when the agent is silent or cannot
    act, when the base is lost, after an invalid velocity, and when the relay starts. A stopping
    relay sends zeros for a second and, except in an emergency, nothing more, so that others can
    drive. Only finite numbers pass.

    When the robot has to stop, the agent cancels its goals at action servers; the relay cancels
    them if the agent is silent. A robot that only has actions has no base.
    """

    def __init__(self, finished: Callable[[], None] = lambda: None, **options: Any) -> None:
        """Start with a stopped robot.

        Args:
            finished: called when the agent has died and the robot stands still.
            options: passed on to the base class.

        Raises:
            HitabError: if a parameter makes no sense.
        """
        super().__init__(names.VELOCITY_RELAY, **options)
        self.finished = finished
        settings = RelaySettings.declare(self, Drive())
        state_dir = declare(self, "state_dir", "")
        self._agent_pid = declare(self, "agent_pid", 0)
        self._kills = declare(self, "kills_hung_agent", False)
        self._stamped = settings.drive.enable_stamped_cmd_vel
        self._gate = Gate(settings.drive, settings.cmd_vel_timeout, time.monotonic())
        self._gate.held = True
        self._file = self._file_in(state_dir)
        self._bases = Bases()
        self._matched = 0
        self._goals = LeftGoals(self)
        self._still_since = time.monotonic()  # when the first of the last zeros was sent
        self._presence = Presence(SILENT_S, STOP_REPORT_PERIOD_S)
        self._presence.hear(AGENT, -SILENT_S)  # silent until the agent's first sign of life
        self._agent_stands = True
        self._measured: tuple[float, Velocity] = (-MEASURED_S, NO_VELOCITY)
        kind = TwistStamped if self._stamped else Twist
        self._base = None
        if settings.drive.moves:
            self._base = self.create_publisher(kind, BASE_TOPIC, QoSProfile(depth=10))
        self._stop: Stop | None = None
        self._stop = Stop(
            self,
            self._stands,
            changed=self._stop_changed,
            rearms=settings.auto_rearm,
            known=self._kept(),
            keep=self._keep,
        )
        self._stop_changed()
        newest = QoSProfile(depth=1)
        self.create_subscription(
            TwistStamped, AGENT_VELOCITY_TOPIC, partial(self._take, False), newest
        )
        self.create_subscription(TwistStamped, names.TELEOP, partial(self._take, True), newest)
        self.create_subscription(StopState, HEARTBEAT, self._on_heartbeat, qos.STREAM)
        self.create_subscription(Odometry, ODOMETRY_TOPIC, self._measure, qos_profile_sensor_data)
        # A paused or slow simulation must not delay a stop.
        steady_timer(self, 1.0 / settings.smoothing_frequency, self._tick)

    def _take(self, by_hand: bool, command: TwistStamped) -> None:
        twist = command.twist
        velocity = (twist.linear.x, twist.linear.y, twist.angular.z)
        was_silent = self._gate.silent
        if why := self._gate.command(velocity, time.monotonic(), by_hand=by_hand):
            self._interrupt(f"{'the person who drives by hand' if by_hand else 'the agent'} {why}")
        if was_silent:
            self._tick()  # send the first velocity at once

    def _on_heartbeat(self, agent: StopState) -> None:
        self._presence.hear(AGENT)
        self._agent_stands = agent.state != StopState.STOPPING
        self._cause(AGENT, "; ".join(agent.causes))
        self._cause(SILENCE, "")

    def _measure(self, odometry: Odometry) -> None:
        twist = odometry.twist.twist
        velocity = (twist.linear.x, twist.linear.y, twist.angular.z)
        self._measured = time.monotonic(), velocity

    def _cause(self, name: str, why: str) -> None:
        if self._stop is not None:
            self._stop.machine.cause(name, why)

    def _interrupt(self, why: str) -> None:
        """Stop the robot for a cause that does not last; re-arming is possible at once."""
        for cause in (why, ""):
            self._cause("interruption", cause)

    def _look_after_base(self, now: float) -> None:
        """Stop the robot until it is re-armed if its base is lost or was restarted."""
        if self._base is None:
            return
        topic = self._base.topic_name
        infos = self.get_subscriptions_info_by_topic(topic)
        if back := self._bases.look({bytes(i.endpoint_gid): name_of(i) for i in infos}, now):
            self._interrupt(f"{some(sorted(back))}, subscribed to {topic}, was started again")
        before, self._matched = self._matched, self._base.get_subscription_count()
        if self._matched > before:
            self._gate.rest(now)  # the base may hold another driver's velocity
            self._still_since = now
        missing = self._bases.missing or not self._matched
        self._cause("base", f"no base subscribes to {topic}" if missing else "")

    def _look_after_agent(self, now: float) -> None:
        """Stop the robot if the agent has died or is silent."""
        unheard_s = self._presence.age(AGENT)
        if self._agent_pid and os.getppid() != self._agent_pid and not self._gate.closed:
            self._gate.closed = self._goals.closed = True
            self._gate.rest(now)  # gives time to cancel its goals, even if the robot stands still
        may_hang = self._agent_pid and not waits_for_cpu_or_disk(self._agent_pid)
        if unheard_s >= (AGENT_HUNG_S if may_hang else SILENT_S):
            self._cause(SILENCE, "its agent gives no sign of life")
        if unheard_s >= REPLACED_AFTER_S and self._kills and not self._gate.closed:
            self.get_logger().error(f"kills the agent, which has hung for {REPLACED_AFTER_S:g} s")
            os.kill(self._agent_pid, signal.SIGKILL)

    def _stands(self) -> bool:
        """Return whether the robot stands still: by its odometry and by what was sent to it."""
        when, velocity = self._measured
        now = time.monotonic()
        if now - when < MEASURED_S and any(
            abs(speed) > most for speed, most in zip(velocity, STANDSTILL, strict=True)
        ):
            return False
        only_zeros = now - self._still_since >= ZEROS_S
        return only_zeros and (self._agent_stands or self._presence.age(AGENT) >= SILENT_S)

    def _tick(self) -> None:
        now = time.monotonic()
        self._look_after_agent(now)
        self._look_after_base(now)
        stopped = self._stop is None or bool(self._stop.machine.why)
        self._gate.held = stopped or self._bases.unnamed
        velocity = self._gate.velocity(now)
        if velocity is not None:
            self._send(velocity)
        elif self._gate.closed:
            self.finished()
        # Of a stopped robot's agent, three signs of life are missed: it cannot cancel its goals.
        is_silent = self._presence.age(AGENT) >= 3 * STOP_REPORT_PERIOD_S
        if self._gate.closed or (stopped and is_silent):
            self._goals.cancel()

    def _send(self, velocity: Velocity) -> None:
        message = TwistStamped() if self._stamped else Twist()
        twist = message
        if self._stamped:
            message.header.stamp = self.get_clock().now().to_msg()
            message.header.frame_id = "base_link"
            twist = message.twist
        twist.linear.x, twist.linear.y, twist.angular.z = velocity
        if velocity != NO_VELOCITY:
            self._still_since = math.inf
        elif self._still_since == math.inf:
            self._still_since = time.monotonic()
        if self._base is not None:
            self._base.publish(message)

    # -- stop ---------------------------------------------------------------------------------

    def _stop_changed(self) -> None:
        if self._stop is None:
            return  # __init__ has not made it yet, and the robot is held
        self._gate.insists = Stop.EMERGENCY in self._stop.machine.causes
        self._tick()

    def _file_in(self, state_dir: str) -> Path | None:
        own = names.own_name(self)
        return Path(state_dir).expanduser() / own / STOP_FILE if state_dir else None

    def _kept(self) -> KnownStops:
        """Return the stops that an earlier relay of this robot has stored."""
        if self._file is None or not self._file.exists():
            return KnownStops()
        try:
            return KnownStops.of_texts(**json.loads(self._file.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError, AttributeError):
            # The stored stops are lost, so assume one: the robot must not move.
            why = f"{self._file} cannot be read"
            return KnownStops().stopped(uuid.uuid4().hex, names.own_name(self), why)

    def _keep(self, known: KnownStops) -> None:
        if self._file is not None:
            # Not synced to disk: the file has to survive only the process, and a sync could delay
            # the next velocity.
            write_durably(self._file, f"{json.dumps(known.texts())}\n".encode(), sync=False)

    def farewell(self) -> None:
        """Stop the robot."""
        with suppress(Exception):  # the process must end in any case
            self._send(NO_VELOCITY)
            if self._base is not None:
                self._base.wait_for_all_acked(Duration(seconds=0.5))


def main() -> None:
    """Run until stopped."""

    def start(spinning: Spinner) -> None:
        spinning.executor.add_node(VelocityRelay(spinning.stop))

    sys.exit(run(start))


if __name__ == "__main__":
    main()
