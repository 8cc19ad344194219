"""Changes of state on a topic, and why they happened."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from hitab_msgs import msg
from rclpy.node import Node

from hitab_core.automaton import FLAGS, START
from hitab_core.running_automaton import RunningAutomaton
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
        self.commanded = False
        self.changed = False

    def look(self) -> None:
        """Find out whether anybody listens."""
        self._heard = self._publisher.get_subscription_count() > 0
        self._countdown = _LOOK_EVERY

    def observe(self, automaton: RunningAutomaton, source: str, destination: str) -> None:
        """Publish a change of state; see `Stage.observe`."""
        self.changed = True
        self._countdown -= 1
        if self._countdown < 0:
            self.look()
        if self._heard:
            self._publisher.publish(self._event(automaton, source, destination))

    def _event(
        self, automaton: RunningAutomaton, source: str, destination: str
    ) -> msg.TransitionEvent:
        path = [automaton.label]
        above = automaton.above
        while above is not None:
            path.append(above.label)
            above = above.above
        event = msg.TransitionEvent(
            stamp=self.stamp,
            cycle=self.cycle,
            agent=self._agent,
            automaton=path[::-1],
            from_state=source,
            to_state=destination,
            probability=1.0,
            commanded=self.commanded and automaton.above is None,
        )
        if not event.commanded:
            # A flag state has fallen back to Start by the time of the decision.
            decided_in = START if source in FLAGS else source
            values = automaton.last_features()
            why = automaton.explain(decided_in, values)
            if why is not None:
                features = automaton.automaton.features
                event.features = [str(features[i].bound(automaton.bindings)) for i in why.features]
                event.values = [values[i] for i in why.features]
                event.probability = float(why.distribution.get(destination, 0.0))
        return event
