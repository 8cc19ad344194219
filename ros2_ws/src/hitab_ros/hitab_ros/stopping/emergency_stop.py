"""Emergency stop of all robots: any participant may issue it, and all agree on it.

Any node may publish on ``/emergency_stop``. Each participant (a robot's relay, the `hitab`
command, the studio) has a switch. Switches publish their known stops
(`hitab_ros.stopping.known_stops`) on ``/emergency_stop/state``, latched, so that participants that
join late or were out of reach receive a stop, and its release, even after the sender has exited.
"""

from __future__ import annotations

import uuid
from collections.abc import Callable
from functools import partial
from typing import Any

from hitab_msgs.msg import EmergencyState, EmergencyStop
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy

from hitab_ros import names, qos
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.steady_timer import steady_timer
from hitab_ros.stopping.known_stops import KnownStops, must_tell
from hitab_ros.timing import REPEAT_S


class EmergencySwitch:
    """One participant's view of the emergency stop.

    Attributes:
        known: the known stops.
    """

    def __init__(
        self,
        node: GuardedNode,
        changed: Callable[[KnownStops], None] = lambda known: None,
        *,
        hands_on: bool = False,
        known: KnownStops | None = None,
    ) -> None:
        """Start listening.

        Args:
            node: node that subscribes and publishes.
            changed: called when the known stops have changed.
            hands_on: whether to rebroadcast received stops. A latched message lasts as long as its
                publisher, and the command that stops the robots may exit at once, so long-lived
                participants, such as the robots' relays, keep the stop for late joiners.
            known: stops that this participant knew at its last exit.
        """
        self.known = KnownStops() if known is None else known
        self._node = node
        self._changed = changed
        self._hands_on = hands_on
        self._hears_latched = False
        self._published = KnownStops()
        self._publisher = node.create_publisher(EmergencyState, names.EMERGENCY_STATE, qos.LATCHED)
        node.create_subscription(
            EmergencyState, names.EMERGENCY_STATE, self._hear_state, qos.LATCHED_BY_MANY
        )
        self._listen(qos.EVENTS, latched=False)
        if hands_on:
            steady_timer(node, REPEAT_S, self._look)
            if known:
                self.tell()

    @property
    def engaged(self) -> bool:
        """Whether the robots have to stand still."""
        return bool(self.known)

    def set(self, engaged: bool, by: str, reason: str = "") -> set[str]:
        """Stop all robots, or release them; return the identities of the stops concerned.

        Args:
            engaged: whether to stop the robots; otherwise all known stops are released.
            by: name of the person or program, for people.
            reason: reason of the stop, for people; may be empty.
        """
        before, identity = self.known, uuid.uuid4().hex
        known = before.stopped(identity, by, reason) if engaged else before.released_by(by)
        self._know(known, known, tells=False)
        self.tell()  # always: others may not know all stops that this participant knows
        return {identity} if engaged else {*before.stops}

    def tell(self) -> None:
        """Publish the known stops."""
        self._published = self.known
        self._publisher.publish(EmergencyState(**self.known.texts()))

    def delivered(self, seconds: float) -> bool:
        """Wait until all discovered listeners have received the stop; return whether they have."""
        return bool(self._publisher.wait_for_all_acked(Duration(seconds=seconds)))

    def _listen(self, profile: Any, *, latched: bool) -> None:
        # Not checked: a stop with invalid texts is still a stop.
        hear = partial(self._hear_event, latched)
        self._node.create_subscription(
            EmergencyStop, names.EMERGENCY_STOP, hear, profile, checked=False
        )

    def _look(self) -> None:
        """Publish unsent stops, and request stops that others latched before this node joined.

        Latched stops are requested only from latching publishers, since others would warn.
        """
        if self.known.stops.keys() - self._published.stops.keys():
            self.tell()
        found = self._node.get_publishers_info_by_topic(names.EMERGENCY_STOP)
        latch = DurabilityPolicy.TRANSIENT_LOCAL
        if not self._hears_latched and any(p.qos_profile.durability == latch for p in found):
            self._hears_latched = True
            self._listen(qos.LATCHED_BY_MANY, latched=True)

    def _hear_event(self, latched: bool, message: EmergencyStop, information: Any) -> None:
        if message.engaged:
            # Equal for all receivers and all deliveries.
            sent = information["source_timestamp"]
            number = information["publication_sequence_number"]
            identity = f"{sent}.{number}" if sent else uuid.uuid4().hex
            known = self.known.stopped(identity, message.by, message.reason)
        elif not latched:
            known = self.known.released_by(message.by)
        else:
            return  # a latched release concerned earlier stops
        self._know(known, known, tells=self._hands_on)

    def _hear_state(self, message: EmergencyState) -> None:
        received = KnownStops.of_texts(message.stops, message.released)
        self._know(self.known.joined(received), received, tells=self._hands_on)

    def _know(self, known: KnownStops, received: KnownStops, *, tells: bool) -> None:
        before, self.known = self.known, known
        if tells and must_tell(before, known, received):
            self.tell()
        if known != before:
            self._changed(known)


def stopped_by(known: KnownStops) -> str:
    """Return a text with the senders and reasons of the stop; empty if no stop is in force."""
    return f"emergency stop by {known.who}" if known else ""
