"""Changes of state on a topic, and why they happened."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from hitab_msgs import msg
from rclpy.node import Node

from hitab_core.running import Change
from hitab_ros import names, qos

_LOOK_EVERY = 64  # changes of state between two looks whether anyone listens


class TransitionLog:
    """Publishes each change of state while somebody listens; costs next to nothing otherwise."""

    def __init__(self, node: Node) -> None:
        self._publisher = node.create_publisher(msg.TransitionEvent, names.TRANSITIONS, qos.EVENTS)
        self._agent = names.own_name(node)
        self._countdown = 0
        self._heard = False
        self.stamp = Time()
        self.cycle = 0
        self.changed = False

    def look(self) -> None:
        """Find out whether anybody listens."""
        self._heard = self._publisher.get_subscription_count() > 0
        self._countdown = _LOOK_EVERY

    def observe(self, change: Change) -> None:
        """Publish a change of state; see `RunContext.observe`.

        Before the action of its cycle is published: whoever hears of the next cycle has then
        heard of this change.
        """
        self.changed = True
        self._countdown -= 1
        if self._countdown < 0:
            self.look()
        if self._heard:
            self._publisher.publish(self._event(change))

    def _event(self, change: Change) -> msg.TransitionEvent:
        event = msg.TransitionEvent(
            stamp=self.stamp,
            cycle=self.cycle,
            agent=self._agent,
            automaton=list(change.automata),
            from_state=change.source,
            to_state=change.destination,
            probability=1.0,
            commanded=change.commanded,
        )
        why = change.explanation()
        if why is not None:
            names = change.features
            event.features = [names[i] for i in why.features]
            event.values = [change.values[i] for i in why.features]
            if why.distribution:
                event.probability = float(why.distribution.get(change.destination, 0.0))
        return event
