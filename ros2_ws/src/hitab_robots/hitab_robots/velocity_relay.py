"""Passes an agent's velocities on to its robot's base, and stops the robot when it has to stop.

A person who drives the robot by hand does so through the relay too, and counts before the agent.

It is a process of its own, since agents die too. The link of an agent starts it; so does, for an
agent whose parameter ``relay`` is false::

    ros2 run hitab_robots velocity_relay --ros-args -r __ns:=/robot_1
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

from geometry_msgs.msg import Twist, TwistStamped
from hitab_msgs.msg import EmergencyStop
from rclpy.duration import Duration
from rclpy.qos import QoSProfile

from hitab_core.library.durable_files import write_durably
from hitab_robots.settings import COMMANDS, VELOCITY, RelaySettings, declare
from hitab_robots.velocity import STILL, Drive, Gate, Velocity
from hitab_ros import EmergencySwitch, GuardedNode, Spinner, names, run, steady_timer
from hitab_ros.stamps import as_time, nanoseconds

FILE = "emergency_stop.json"


class VelocityRelay(GuardedNode):
    """Sends the base the agent's velocities within limits; zero when the robot has to stop.

    What a person sends on ``cmd_vel_teleop`` counts instead of the agent's. The relay stops the
    robot when both have been silent for `cmd_vel_timeout`, whatever the reason, and while the
    emergency stop is engaged. Then it sends zeros for a second and, unless it is an emergency,
    nothing more, so that others can drive. What is not a finite number never passes.
    """

    def __init__(self, finished: Callable[[], None] = lambda: None, **options: Any) -> None:
        """Start.

        Args:
            finished: called when its agent is gone and the robot stands still.
            options: passed on to the base class.

        Raises:
            HitabError: if a parameter makes no sense.
        """
        super().__init__(names.VELOCITY_RELAY, **options)
        self.finished = finished
        settings = RelaySettings.declare(self, Drive())
        state_dir = declare(self, "state_dir", "")
        self._agent_pid = declare(self, "agent_pid", 0)
        self._stamped = settings.drive.enable_stamped_cmd_vel
        self._gate = Gate(settings.drive, settings.cmd_vel_timeout, time.monotonic())
        self._file = self._file_in(state_dir)
        kind = TwistStamped if self._stamped else Twist
        self._base = self.create_publisher(kind, COMMANDS, QoSProfile(depth=10))
        self._switch = EmergencySwitch(self, self._emergency, hands_on=True, state=self._kept())
        newest = QoSProfile(depth=1)
        self.create_subscription(TwistStamped, VELOCITY, self._on_velocity, newest)
        self.create_subscription(TwistStamped, names.TELEOP, self._on_teleop, newest)
        # A paused or slow simulation must not delay a stop.
        steady_timer(self, 1.0 / settings.smoothing_frequency, self._tick)

    def _on_velocity(self, command: TwistStamped) -> None:
        self._take(command, "the agent", by_hand=False)

    def _on_teleop(self, command: TwistStamped) -> None:
        self._take(command, "the person who drives by hand", by_hand=True)

    def _take(self, command: TwistStamped, who: str, *, by_hand: bool) -> None:
        twist = command.twist
        velocity = (twist.linear.x, twist.linear.y, twist.angular.z)
        was_silent = self._gate.silent
        if not self._gate.command(velocity, time.monotonic(), by_hand=by_hand):
            self.guard.log(f"{who} commands {velocity}, which is no velocity: stopping")
        if was_silent:
            self._tick()  # do not have the robot wait when it starts

    def _tick(self) -> None:
        if self._agent_pid and os.getppid() != self._agent_pid:
            self._gate.closed = True
        velocity = self._gate.velocity(time.monotonic())
        if velocity is not None:
            self._send(velocity)
        elif self._gate.closed:
            self.finished()

    def _send(self, velocity: Velocity) -> None:
        message = TwistStamped() if self._stamped else Twist()
        twist = message
        if self._stamped:
            message.header.stamp = self.get_clock().now().to_msg()
            message.header.frame_id = "base_link"
            twist = message.twist
        twist.linear.x, twist.linear.y, twist.angular.z = velocity
        self._base.publish(message)

    # -- emergency stop -----------------------------------------------------------------------

    def _emergency(self, state: EmergencyStop) -> None:
        self._gate.engaged = state.engaged
        self._tick()
        what = "stopped" if state.engaged else "released"
        why = f": {state.reason}" if state.reason else ""
        self.get_logger().warning(f"{what} by {state.by or 'somebody'}{why}")
        self._keep(state)

    def _file_in(self, state_dir: str) -> Path | None:
        own = names.own_name(self)
        return Path(state_dir).expanduser() / own / FILE if state_dir else None

    def _kept(self) -> EmergencyStop | None:
        """Return what counted when an earlier relay of this robot ended."""
        if self._file is None or not self._file.exists():
            return None
        try:
            kept = json.loads(self._file.read_text(encoding="utf-8"))
            return EmergencyStop(
                stamp=as_time(int(kept["stamp"])),
                engaged=bool(kept["engaged"]),
                by=str(kept["by"]),
                reason=str(kept["reason"]),
            )
        except (OSError, ValueError, KeyError, TypeError, AssertionError):
            # Which of the two it was is not known: the one that moves nothing is assumed.
            return EmergencyStop(
                stamp=as_time(1),
                engaged=True,
                by=names.own_name(self),
                reason=f"{self._file} cannot be read",
            )

    def _keep(self, state: EmergencyStop) -> None:
        if self._file is None:
            return
        kept = {
            "stamp": nanoseconds(state.stamp),
            "engaged": state.engaged,
            "by": state.by,
            "reason": state.reason,
        }
        # Not synced: it has to survive the relay, and a sync could delay the next velocity.
        write_durably(self._file, f"{json.dumps(kept)}\n".encode(), sync=False)

    def destroy_node(self) -> None:
        """Stop the robot, then destroy the node."""
        with suppress(Exception):  # nothing may keep the process from ending
            self._send(STILL)
            self._base.wait_for_all_acked(Duration(seconds=0.5))
        super().destroy_node()


def main() -> None:
    """Run until stopped."""

    def start(spinning: Spinner) -> None:
        spinning.executor.add_node(VelocityRelay(spinning.stop))

    sys.exit(run(start))


if __name__ == "__main__":
    main()
