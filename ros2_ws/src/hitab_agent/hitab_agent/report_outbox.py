"""Sending the reports of the agents of one process to their commanders."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from hitab_msgs import msg
from rclpy.node import Node

from hitab_core.order import Report
from hitab_ros import names, qos
from hitab_ros.conversions import report_message


class ReportOutbox:
    """Has a publisher for each commander; while it is held, a commander gets one message for all.

    The agents of a host share one.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._publishers: dict[str, Any] = {}
        self._held: dict[str, list[msg.Report]] | None = None

    def open(self, topic: str) -> None:
        """Make ready to send to a commander: some time has to pass before it hears."""
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(msg.Reports, topic, qos.EVENTS)

    def send(self, topic: str, report: Report) -> None:
        """Send a report, now or when the outbox is no longer held."""
        message = report_message(report)
        if self._held is None:
            self._publishers[topic].publish(msg.Reports(reports=[message]))
        else:
            self._held.setdefault(topic, []).append(message)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Gather what is sent meanwhile; send it at the end."""
        if self._held is not None:
            yield
            return
        self._held = {}
        try:
            yield
        finally:
            held, self._held = self._held, None
            for topic, reports in held.items():
                self._publishers[topic].publish(msg.Reports(reports=reports))


def reports_topic(node: Node, commander: str) -> str:
    """Return the topic on which a commander of the node's swarm hears reports."""
    return names.in_swarm(node, commander, names.REPORTS)
