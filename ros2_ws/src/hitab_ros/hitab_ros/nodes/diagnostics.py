"""Diagnostics of a process on ROS's topic ``/diagnostics``, for rqt and other tools.

A process publishes one message per second, however many agents it runs, and one soon after a
change.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import IntEnum

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.qos import QoSProfile

from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.steady_timer import steady_timer
from hitab_ros.timing import LOOK_EACH_S, REPEAT_S, UPDATE_S

DIAGNOSTICS_TOPIC = "/diagnostics"  # absolute, as in REP 107

STATUSES_MAX = 50
"""Maximum number of statuses in a message; of many agents, only those with faults are listed."""


class Level(IntEnum):
    """Severity, as numbered in ``diagnostic_msgs/DiagnosticStatus``."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3

    @property
    def severity(self) -> int:
        """Order of severity: an error is worse than an unknown state."""
        return (Level.OK, Level.WARN, Level.STALE, Level.ERROR).index(self)


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """Faults of one agent or world; cheap to create, since few of many are shown.

    Attributes:
        name: name of the agent or world.
        hardware: unique name of the diagnosed part.
        found: faults with their levels; the first of the worst level is the message.
        details: returns the message if nothing is wrong, and further values by key.
    """

    name: str
    hardware: str
    found: Sequence[tuple[Level, str]]
    details: Callable[[], tuple[str, Mapping[str, object]]]

    @property
    def level(self) -> Level:
        """The worst level of the faults."""
        return self._worst[0] if self.found else Level.OK

    @property
    def _worst(self) -> tuple[Level, str]:
        return max(self.found, key=lambda one: one[0].severity)

    def status(self) -> DiagnosticStatus:
        """Return the diagnosis as a message."""
        fine, values = self.details()
        level, message = self._worst if self.found else (Level.OK, fine)
        if len(self.found) > 1:
            message += f" (and {len(self.found) - 1} more)"
        values = {**values, **{f"problem {i}": text for i, (_, text) in enumerate(self.found, 1)}}
        return DiagnosticStatus(
            level=bytes([level]),
            name=f"hitab: {self.name}",
            message=message,
            hardware_id=self.hardware,
            values=[KeyValue(key=key, value=str(value)) for key, value in values.items()],
        )


class Diagnostics:
    """Publishes the statuses of a process, if there is a subscriber."""

    def __init__(self, node: GuardedNode, read: Callable[[], Sequence[Diagnosis]]) -> None:
        """Start publishing.

        Args:
            node: node that represents its process.
            read: returns a diagnosis for each agent of the process, or for its world.
        """
        self._read = read
        self._node = node
        self._heard = self._due = False
        self._publisher = node.create_publisher(
            DiagnosticArray, DIAGNOSTICS_TOPIC, QoSProfile(depth=10)
        )
        steady_timer(node, REPEAT_S, self._look)
        self._soon = steady_timer(node, UPDATE_S, self._publish)
        self._soon.cancel()

    def soon(self) -> None:
        """Publish soon, since something has changed."""
        if self._heard and not self._due:
            self._due = True
            self._soon.reset()

    def _look(self) -> None:
        self._heard = self._publisher.get_subscription_count() > 0
        if self._heard:
            self._publish()

    def _publish(self) -> None:
        self._due = False
        self._soon.cancel()
        found = self._read()
        self._soon.timer_period_ns = int(max(UPDATE_S, len(found) * LOOK_EACH_S) * 1e9)
        array = DiagnosticArray(status=shown(found, self._node.get_namespace()))
        array.header.stamp = self._node.get_clock().now().to_msg()
        self._publisher.publish(array)


def shown(found: Sequence[Diagnosis], process: str) -> list[DiagnosticStatus]:
    """Return the status of one agent; for several, a summary and the statuses with faults.

    Args:
        found: diagnoses of the agents of a process.
        process: namespace of the process's node.
    """
    if len(found) <= 1:
        return [one.status() for one in found]
    counts = Counter(one.level for one in found)
    tally = ", ".join(f"{counts[level]} {level.name}" for level in Level if counts[level])
    worst = max(counts, key=lambda level: level.severity)
    values = {"agents": len(found)} | {level.name: counts[level] for level in Level}
    summary = Diagnosis(
        process.rpartition("/")[2],
        process,
        [] if worst is Level.OK else [(worst, tally)],
        lambda: (tally, values),
    )
    wrong = [one for one in found if one.found]
    wrong.sort(key=lambda one: one.level.severity, reverse=True)
    return [summary.status(), *(one.status() for one in wrong[:STATUSES_MAX])]
