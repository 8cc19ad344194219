"""The topic on which a host publishes the statuses of its agents and groups."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import JobQueue, Scheduler
from hitab_ros import GuardedNode, Receivers, names, qos
from hitab_ros.timing import POLL_S, TURN_S

STATUSES_MAX = 100
"""Maximum number of statuses in a message, so that reading one delays nothing else."""


class Group(Protocol):
    """A commander's group."""

    def message(self) -> msg.CommanderStatus:
        """Return the group's status now."""


class StatusBatches:
    """Publishes what has changed, in batches, and everything when a new subscriber appears.

    Without a subscriber nothing is sent.

    Attributes:
        groups: the groups of the host's commanders; each adds itself.
    """

    def __init__(
        self, host: GuardedNode, nodes: Sequence[AgentBase], scheduler: Scheduler
    ) -> None:
        """Create the publisher.

        Args:
            host: a node of the host, in its own namespace.
            nodes: the nodes of its agents, read at each look for subscribers.
            scheduler: the process's scheduler.
        """
        self.groups: list[Group] = []
        self._nodes = nodes
        self._name = names.own_name(host)
        self._publisher = host.create_publisher(
            msg.HostStatuses, names.in_swarm(host, names.STATUSES), qos.STATUSES
        )
        self._receivers = Receivers(host, self._publisher)
        self._jobs = JobQueue(host, TURN_S)
        self._statuses: dict[str, msg.AgentStatus] = {}
        self._changed: dict[Group, None] = {}
        scheduler.every(POLL_S, self._look)

    @property
    def are_read(self) -> bool:
        """Whether somebody reads them."""
        return self._publisher.get_subscription_count() > 0

    def tell_status(self, status: msg.AgentStatus) -> None:
        """Publish an agent's changed status a little later."""
        if self.are_read:
            self._flush_later()
            self._statuses[status.agent] = status

    def tell_group(self, group: Group) -> None:
        """Publish a changed group a little later."""
        if self.are_read:
            self._flush_later()
            self._changed[group] = None

    def _flush_later(self) -> None:
        if not self._statuses and not self._changed:
            self._jobs.do(self._flush())

    def _flush(self) -> Iterator[None]:
        statuses, groups = [*self._statuses.values()], [*self._changed]
        self._statuses.clear()
        self._changed.clear()
        yield from self._publish(statuses, groups)

    def _look(self) -> None:
        if self._receivers.look():
            statuses = [node.status.message for node in self._nodes]
            self._jobs.do(self._publish(statuses, [*self.groups]))

    def _publish(
        self, statuses: Sequence[msg.AgentStatus], groups: Sequence[Group]
    ) -> Iterator[None]:
        for begin in range(0, len(statuses), STATUSES_MAX):
            self._send(agents=[*statuses[begin : begin + STATUSES_MAX]])
            yield None
        for begin in range(0, len(groups), STATUSES_MAX):
            some = groups[begin : begin + STATUSES_MAX]
            self._send(groups=[group.message() for group in some])
            yield None

    def _send(self, **fields: Any) -> None:
        self._publisher.publish(msg.HostStatuses(host=self._name, **fields))
