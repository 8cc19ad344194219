"""Sending the reports of the agents of one process to their commanders."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from hitab_msgs import msg

from hitab_agent.deferred import Deferred
from hitab_core.commanding import Report
from hitab_ros import GuardedNode, names, qos
from hitab_ros.conversions import report_message


class ReportOutbox:
    """Has a publisher for each commander; while it is held, a commander gets one message for all.

    The agents of a host share one. There a report waits a little for others, so that a commander
    gets one message when an order has changed what all its subordinates do, and orders pass
    further down before anybody looks at what has become of them.
    """

    def __init__(self, node: GuardedNode, later: Deferred | None = None) -> None:
        """Make it.

        Args:
            node: to publish on.
            later: when reports are sent; None: at once.
        """
        self._node = node
        self._later = later
        self._publishers: dict[str, Any] = {}
        self._waiting: dict[str, list[msg.Report]] = {}
        self._held = False

    def open(self, topic: str) -> None:
        """Make ready to send to a commander: some time has to pass before it hears."""
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(msg.Reports, topic, qos.EVENTS)

    def send(self, topic: str, report: Report) -> None:
        """Send a report, now, a little later, or when the outbox is no longer held."""
        if self._later is not None and not self._waiting:
            self._later.call(self._flush)
        self._waiting.setdefault(topic, []).append(report_message(report))
        if self._later is None and not self._held:
            self._flush()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Gather what is sent meanwhile; send it at the end."""
        if self._held:
            yield
            return
        self._held = True
        try:
            yield
        finally:
            self._held = False
            if self._later is None:
                self._flush()

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Gather what is sent meanwhile, and send it at the end without waiting for others."""
        with self.held():
            yield
        self._flush()

    def _flush(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for topic, reports in waiting.items():
            self._node.guard.run(f"reports on {topic}", self._publish, topic, reports)

    def _publish(self, topic: str, reports: list[msg.Report]) -> None:
        self._publishers[topic].publish(msg.Reports(reports=reports))


def reports_topic(node: GuardedNode, commander: str) -> str:
    """Return the topic on which a commander of the node's swarm hears reports."""
    return names.in_swarm(node, commander, names.REPORTS)
