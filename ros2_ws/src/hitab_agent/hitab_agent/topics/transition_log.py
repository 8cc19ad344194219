"""The topic and the log of an agent's state changes, with their reasons."""

from __future__ import annotations

from builtin_interfaces.msg import Time
from hitab_msgs import msg

from hitab_agent.endpoints import PublishedTopic
from hitab_core.running import Change
from hitab_ros import GuardedNode, SparingLog, names, qos
from hitab_ros.messages.conversions import values_message
from hitab_ros.timing import POLL_S


class TransitionLog:
    """Publishes each state change while the topic has subscribers; otherwise costs almost nothing.

    The changes can also be logged, at info level and a limited rate, while ``/rosout`` has a
    subscriber.

    Attributes:
        topic: the topic.
        stamp, cycle: time and number of the agent's present cycle.
        changed: whether there was a change since this was last set.
    """

    def __init__(self, node: GuardedNode, *, logs: bool = False) -> None:
        """Prepare to publish.

        Args:
            node: the agent's node.
            logs: whether to log changes as well.
        """
        self._node = node
        self._logs = logs
        self._write: SparingLog | None = None
        self.topic = PublishedTopic(node, msg.TransitionEvent, names.TRANSITIONS, qos.EVENTS)
        self._agent = names.own_name(node)
        self.stamp = Time()
        self.cycle = 0
        self.changed = False

    def look(self) -> None:
        """Check whether the log has a subscriber."""
        listened = self._logs and self._node.count_subscribers(names.ROSOUT) > 0
        if not listened:
            self._write = None
        elif self._write is None:
            self._write = SparingLog(self._node.get_logger().info, refill_s=POLL_S)

    def observe(self, change: Change) -> None:
        """Publish a state change; see `RunContext.observe`.

        A change is published before the action of its cycle, so subscribers have it before the
        next cycle.
        """
        self.changed = True
        if self.topic.is_listened_to:
            self.topic.publish(self._event(change))
        if self._write is not None:
            self._write(f"{self._agent}: {_in_one_line(change)}", object())

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
            event.features = values_message((names[i], change.values[i]) for i in why.features)
            if why.distribution:
                event.probability = float(why.distribution.get(change.destination, 0.0))
        return event


def _in_one_line(change: Change) -> str:
    """Return a state change in one line: the automaton, both states and the reason."""
    why = change.explanation()
    reason = "commanded" if change.commanded else ", ".join(why.tests) if why is not None else ""
    where = "/".join(change.automata)
    return f"{where}: {change.source} -> {change.destination}" + (f" ({reason})" if reason else "")
