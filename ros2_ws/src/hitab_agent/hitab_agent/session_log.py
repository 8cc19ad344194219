"""What an agent took in, on topics, while somebody records it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from hitab_msgs import msg
from std_msgs.msg import String

from hitab_agent.agent_base import AgentBase
from hitab_ros import Receivers, qos, session_topics

LOOK_PERIOD_S = 0.25

Serve = Callable[[Any, Any], Any]
"""Fills in the response to a request."""

_QOS = {
    session_topics.PERCEIVED: session_topics.PERCEPTS_QOS,
    session_topics.COMMANDED: qos.EVENTS,
    session_topics.REQUESTED: qos.EVENTS,
    session_topics.KNOWN: qos.EVENTS,
}


class SessionLog:
    """Publishes the topics of a recorded session; without a subscriber it only looks for one.

    To each new subscriber it first says what the agent knows, and what it perceived last: in a
    paused world nothing else comes before the first command.
    """

    def __init__(self, node: AgentBase) -> None:
        """Begin to look for subscribers, unless the agent is one of a host."""
        self._node = node
        self._publishers: dict[str, Any] = {}
        self._receivers: list[Receivers] = []
        self._listeners = 0
        self._last: msg.Percept | None = None
        if node.shared.host is None:
            node.shared.ticker.every(LOOK_PERIOD_S, self._look, node.guard)

    def tell(self, topic: str, message: Any) -> None:
        """Publish what the agent is about to take in: a percept, a command or a request."""
        if topic == session_topics.PERCEIVED:
            self._last = message
        if self._listeners:
            self._publishers[topic].publish(message)

    def searched(self) -> None:
        """Publish that questions have just been looked for, which gives them their numbers."""
        text = session_topics.request_text(session_topics.SEARCHED, None)
        self.tell(session_topics.REQUESTED, String(data=text))

    def _look(self) -> None:
        """Begin, or end, with the subscribers."""
        if not self._publishers:
            if not self._node.count_subscribers(session_topics.PERCEIVED):
                return
            for name, kind in session_topics.TOPICS.items():
                publisher = self._node.create_publisher(kind, name, _QOS[name])
                self._publishers[name] = publisher
                self._receivers.append(Receivers(self._node, publisher))
        changed = [receivers.look() for receivers in self._receivers]
        self._listeners = min(receivers.count for receivers in self._receivers)
        if self._listeners and any(changed):
            self._publishers[session_topics.KNOWN].publish(self._known())
            if self._last is not None:
                self._publishers[session_topics.PERCEIVED].publish(self._last)

    def telling(self, service: str, serve: Serve) -> Serve:
        """Return what serves a request and publishes it before."""
        if service not in session_topics.SERVICES:
            return serve

        def told(request: Any, response: Any) -> Any:
            text = session_topics.request_text(service, request)
            self.tell(session_topics.REQUESTED, String(data=text))
            return serve(request, response)

        return told

    def _known(self) -> msg.Distribution:
        texts = self._node.agent.edition.texts
        return msg.Distribution(
            source=self._node.agent.name,
            digest=self._node.agent.edition.digest,
            files=[msg.BehaviorFile(name=name, text=texts[name]) for name in sorted(texts)],
        )
