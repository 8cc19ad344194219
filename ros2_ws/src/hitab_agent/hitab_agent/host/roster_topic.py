"""The topic on which a host publishes which agents it runs, and sees which others do."""

from __future__ import annotations

import time
from collections.abc import Sequence

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.scheduler import Scheduler
from hitab_core import some
from hitab_ros import GuardedNode, HostRosters, names, qos
from hitab_ros.timing import REPEAT_S


class RosterTopic:
    """Publishes a host's roster, and reports other hosts that run one of its agents as a fault.

    A host publishes its roster again when another one was published in its name.

    Two hosts that start at once do not see each other's rosters before they publish their own.

    Attributes:
        machine: name of the machine that the host runs on; empty in a swarm on one machine.
        number: number of the last published roster; 0 before the first.
    """

    def __init__(
        self,
        host: GuardedNode,
        nodes: Sequence[AgentBase],
        swarm: str,
        rosters: HostRosters,
        scheduler: Scheduler,
        machine: str = "",
    ) -> None:
        """Create the publisher.

        Args:
            host: a node of the host, in its own namespace.
            nodes: the nodes of all its agents.
            swarm: identity of the agents' swarm; empty if none.
            rosters: the rosters of all hosts.
            scheduler: the process's scheduler.
            machine: name of the machine that it runs on; empty in a swarm on one machine.
        """
        self.machine = machine
        self.number = 0
        self._wrong = 0  # number of a wrong roster in this host's name
        self._name = names.own_name(host)
        self._nodes = nodes
        self._swarm = swarm
        self._host = host
        self._publisher = host.create_publisher(
            msg.HostRoster, names.in_swarm(host, names.HOSTS), qos.LATCHED
        )
        rosters.changed.append(self._hear)
        scheduler.every(REPEAT_S, self._correct)

    def publish(self, after: int = 0) -> None:
        """Publish the roster with a higher number than any before, and than another one."""
        # The number is the time of day, so that a restarted host has a higher one.
        self.number = max(time.time_ns(), self.number + 1, after + 1)
        self._publisher.publish(
            msg.HostRoster(
                host=self._name,
                number=self.number,
                agents=self._agents,
                machine=self.machine,
                swarm=self._swarm,
            )
        )

    @property
    def _agents(self) -> list[str]:
        return [node.agent_name for node in self._nodes]

    def _correct(self) -> None:
        if self._wrong > self.number > 0:
            self.publish(self._wrong)

    def _hear(self, roster: msg.HostRoster) -> None:
        if roster.host == self._name and roster.agents != self._agents:
            self._wrong = roster.number
        if roster.host == self._name or not self.number:
            return
        both = set(self._agents).intersection(roster.agents)
        key = f"roster of {roster.host}"
        why = f"{some(sorted(both))} also run in {roster.host}; stop one of the two hosts"
        self._host.guard.faults.set(key, why if both else "")
