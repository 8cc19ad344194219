"""Driving of one robot by hand, through its relay.

The relay applies its limits and the emergency stop, and stops the robot when no velocity arrives;
see docs/robots.md.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from typing import Any

from geometry_msgs.msg import TwistStamped
from rclpy.qos import QoSProfile

from hitab_ros import GuardedNode, names, steady_timer
from hitab_ros.timing import AT_ONCE_S

Velocity = tuple[float, float, float]
"""Velocity: m/s ahead, m/s to the left, rad/s (REP 103)."""

STILL: Velocity = (0.0, 0.0, 0.0)


class Steering:
    """Sends a velocity while the person holds the keys, and then one zero.

    Args:
        node: node that publishes the velocities.
        prefix: namespace of the swarm.
        may_drive: returns whether nothing else drives the robot; called before each message.
        clock: returns the time of any steady clock, s.

    Attributes:
        until: end of the wanted velocity by the clock, s.
    """

    def __init__(
        self,
        node: GuardedNode,
        prefix: str = "",
        may_drive: Callable[[], bool] = lambda: True,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._node = node
        self._prefix = prefix
        self._may_drive = may_drive
        self._clock = clock
        self._agent = ""
        self._topic: Any = None
        self._wanted = STILL
        self.until = -math.inf
        self._sent = STILL
        steady_timer(node, AT_ONCE_S, self._tick)

    def choose(self, agent: str) -> None:
        """Drive another robot from now on; the last one stops."""
        self.release()
        if agent == self._agent:
            return
        if self._topic is not None:
            self._node.destroy_publisher(self._topic)
        self._agent = agent
        topic = names.of_agent(agent, names.TELEOP, self._prefix)
        self._topic = self._node.create_publisher(
            TwistStamped, topic, QoSProfile(depth=1), temporary=True
        )

    @property
    def velocity(self) -> Velocity:
        """The velocity sent last."""
        return self._sent

    @property
    def is_held(self) -> bool:
        """Whether the person wants the robot to move."""
        return self._clock() <= self.until

    @property
    def reaches_relay(self) -> bool:
        """Whether the robot has a relay that listens."""
        return self._topic is not None and self._topic.get_subscription_count() > 0

    @property
    def topic_name(self) -> str:
        """Topic of the velocities; empty before the first one."""
        return "" if self._topic is None else self._topic.topic_name

    def hold(self, velocity: Sequence[float], seconds: float) -> None:
        """Request a velocity for some seconds; a non-finite velocity releases the robot."""
        if len(velocity) != 3 or not all(map(math.isfinite, velocity)) or not any(velocity):
            self.release()
            return
        self._wanted = (velocity[0], velocity[1], velocity[2])
        self.until = self._clock() + seconds

    def release(self) -> None:
        """Stop the robot at once."""
        self.until = -math.inf
        self._tick()

    def _tick(self) -> None:
        if self.is_held and self._may_drive():
            self._send(self._wanted)
        elif self._sent != STILL:
            self._send(STILL)

    def _send(self, velocity: Velocity) -> None:
        self._sent = velocity
        if self._topic is None:
            return
        message = TwistStamped()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.header.frame_id = "base_link"
        twist = message.twist
        twist.linear.x, twist.linear.y, twist.angular.z = velocity
        self._topic.publish(message)
