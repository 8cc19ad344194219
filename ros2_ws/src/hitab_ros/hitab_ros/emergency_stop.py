"""The emergency stop of all robots: one latched topic, whose newest message counts.

Whoever takes part, a robot's relay, the `hitab` command or the studio, has a switch. The message
with the latest stamp wins, so that it does not matter in which order somebody who comes late hears
what several publishers have latched. A switch stamps its own messages later than all that it has
heard, so that clocks that differ do not keep a person from stopping, or releasing, the robots.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from hitab_msgs.msg import EmergencyStop
from rclpy.duration import Duration
from rclpy.node import Node

from hitab_ros import names, qos
from hitab_ros.checks import too_far_ahead
from hitab_ros.stamps import as_time, nanoseconds


class EmergencySwitch:
    """One participant's view of the emergency stop.

    Attributes:
        state: the message that counts; None: none was heard.
    """

    def __init__(
        self,
        node: Node,
        changed: Callable[[EmergencyStop], None] = lambda state: None,
        *,
        hands_on: bool = False,
    ) -> None:
        """Listen.

        Args:
            node: to listen and speak with.
            changed: called when the robots are stopped or released, with the new state.
            hands_on: whether to publish what was heard again. A latched message lasts as long as
                its publisher, and the command that stops the robots ends at once; so the robots'
                relays keep it for those who come later.
        """
        self.state: EmergencyStop | None = None
        self._node = node
        self._changed = changed
        self._hands_on = hands_on
        self._publisher: Any = None
        if hands_on:
            self._open()
        # A latched subscription gets what was said before it came, but hears nobody who latches
        # nothing, such as `ros2 topic pub --once`; the other one hears everybody.
        self._subscriptions = [
            node.create_subscription(EmergencyStop, names.EMERGENCY_STOP, self.take, profile)
            for profile in (qos.LATCHED, qos.EVENTS)
        ]

    @property
    def engaged(self) -> bool:
        """Whether the robots have to stand still."""
        return self.state is not None and self.state.engaged

    def set(self, engaged: bool, by: str, reason: str = "") -> EmergencyStop:
        """Stop all robots, or release them; return the message, which counts from now on.

        Args:
            engaged: whether they have to stand still.
            by: who wants it, for people.
            reason: for people; may be empty.
        """
        message = EmergencyStop(engaged=engaged, by=by, reason=reason)
        message.stamp = as_time(self._next_stamp())
        self._keep(message)
        self._open().publish(message)
        return message

    def delivered(self, seconds: float) -> bool:
        """Wait until all listeners found so far have what was set; return whether they do."""
        return bool(self._open().wait_for_all_acked(Duration(seconds=seconds)))

    def _open(self) -> Any:
        if self._publisher is None:
            self._publisher = self._node.create_publisher(
                EmergencyStop, names.EMERGENCY_STOP, qos.LATCHED
            )
        return self._publisher

    def _next_stamp(self) -> int:
        last = -1 if self.state is None else nanoseconds(self.state.stamp)
        return max(time.time_ns(), last + 1)

    def take(self, message: EmergencyStop) -> None:
        """Take what was heard, or what counted when this participant ended."""
        stamp = nanoseconds(message.stamp)
        # By hand, as with `ros2 topic pub`, or by a clock that nobody could ever overtake.
        if stamp <= 0 or too_far_ahead(stamp):
            message.stamp = as_time(self._next_stamp())
        if self.state is not None and not supersedes(message, self.state):
            return
        was = None if self.state is None else self.state.engaged
        self._keep(message)
        if self._hands_on and was is not message.engaged:
            self._open().publish(message)

    def _keep(self, message: EmergencyStop) -> None:
        was = self.engaged
        self.state = message
        if was is not message.engaged:
            self._changed(message)


def supersedes(message: EmergencyStop, state: EmergencyStop) -> bool:
    """Whether a message counts instead of what counted: it is later, or as late and stops."""
    new, old = nanoseconds(message.stamp), nanoseconds(state.stamp)
    return new > old or (new == old and message.engaged and not state.engaged)


def stopped_by(state: EmergencyStop) -> str:
    """Return who stopped the robots, and why; empty: the stop is released."""
    if not state.engaged:
        return ""
    why = f" ({state.reason})" if state.reason else ""
    return f"emergency stop by {state.by or 'somebody'}{why}"
