"""The outbox of agents' reports to their commanders, one for each process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from hitab_msgs import msg

from hitab_agent.scheduler import JobQueue
from hitab_core.orders import Report
from hitab_ros import GuardedNode, names, qos
from hitab_ros.messages.conversions import message_of


class ReportOutbox:
    """Publishes reports on one topic per commander; a held outbox collects them first.

    All agents of a host share an outbox, which delays reports briefly. So a commander gets one
    message after an order has changed all its subordinates, and orders are passed down the
    hierarchy before their outcome is reported up.
    """

    def __init__(self, node: GuardedNode, later: JobQueue | None = None) -> None:
        """Create the outbox without publishers.

        Args:
            node: the node to publish on.
            later: delays reports; None to send them at once.
        """
        self._node = node
        self._process = names.own_name(node)
        self._later = later
        self._publishers: dict[str, Any] = {}
        self._waiting: dict[str, list[msg.Report]] = {}
        self._held = False

    def open(self, topic: str) -> None:
        """Create the publisher for a commander early, since discovery takes time."""
        if topic not in self._publishers:
            self._publishers[topic] = self._node.create_publisher(msg.Reports, topic, qos.EVENTS)

    def send(self, topic: str, report: Report) -> None:
        """Send a report: at once, after the outbox's delay, or when the outbox is released."""
        if self._later is not None and not self._waiting:
            self._later.call(self._flush)
        self._waiting.setdefault(topic, []).append(message_of(msg.Report, report))
        if self._later is None and not self._held:
            self._flush()

    @contextmanager
    def held(self) -> Iterator[None]:
        """Collect reports during the block; send them at its end."""
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
        """Collect reports during the block; send them at its end, without further delay."""
        with self.held():
            yield
        self._flush()

    def _flush(self) -> None:
        waiting, self._waiting = self._waiting, {}
        for topic, reports in waiting.items():
            self._node.guard.run(f"reports on {topic}", self._publish, topic, reports)

    def _publish(self, topic: str, reports: list[msg.Report]) -> None:
        self._publishers[topic].publish(msg.Reports(process=self._process, reports=reports))
