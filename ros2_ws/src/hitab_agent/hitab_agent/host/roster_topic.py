"""The topic on which a host publishes which agents it runs, and sees which others do."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_agent.node.restart_memory import RestartMemory
from hitab_agent.scheduler import Scheduler
from hitab_core import some
from hitab_ros import GuardedNode, HostRosters, Lease, names, qos
from hitab_ros.leases import rank
from hitab_ros.messages.checks import too_far_ahead
from hitab_ros.timing import REPEAT_S


class RosterTopic:
    """Publishes a host's roster, and notices other hosts that run one of its agents.

    With a lease, the host yields to another one of its swarm whose roster has precedence, see
    `hitab_ros.leases`; otherwise the other host is a fault.

    A host publishes its roster again when another one was published in its name.

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
        lease: Lease,
        give_up: Callable[[str], None],
    ) -> None:
        """Create the publisher.

        Args:
            host: a node of the host, in its own namespace.
            nodes: the nodes of all its agents.
            swarm: identity of the agents' swarm; empty if none.
            rosters: the rosters of all hosts.
            scheduler: the process's scheduler.
            lease: the host's lease.
            give_up: called with the reason if the host yields; ends the process at once.
        """
        self.machine = lease.machine
        self.number = 0
        self._lease = lease
        self._give_up = give_up
        self._memory: RestartMemory | None = None
        self._rosters = rosters
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

    def remember(self, state_dir: Path) -> None:
        """Give rosters higher numbers than the processes before, whatever the clock says.

        Args:
            state_dir: the folder of all agents' state.
        """
        self._memory = RestartMemory(state_dir, self._name, self._swarm)

    def publish(self, after: int = 0) -> None:
        """Publish the roster with a higher number than any before, and than another one."""
        is_first, memory = not self.number, self._memory
        kept = memory.values.get("number") if memory is not None else None
        if isinstance(kept, int) and not too_far_ahead(kept):  # else nobody accepts a higher one
            after = max(after, kept)
        # The number is the time of day, so that a restarted host has a higher one.
        self.number = max(time.time_ns(), self.number + 1, after + 1)
        if memory is not None:
            self._host.guard.run("number of the roster", memory.keep, {"number": self.number})
        self._publisher.publish(self._roster)
        # Of two hosts that start at once, none hears the other one before it publishes.
        for roster in self._rosters.rosters.values() if is_first else ():
            self._hear(roster)

    @property
    def _agents(self) -> list[str]:
        return [node.agent_name for node in self._nodes]

    @property
    def _roster(self) -> msg.HostRoster:
        return msg.HostRoster(
            host=self._name,
            number=self.number,
            agents=self._agents,
            machine=self._lease.machine,
            lease=self._lease.number,
            swarm=self._swarm,
        )

    def _correct(self) -> None:
        if self._wrong > self.number > 0:
            self.publish(self._wrong)

    def _hear(self, roster: msg.HostRoster) -> None:
        is_of_own_name, lease = roster.host == self._name, Lease(roster.machine, roster.lease)
        if is_of_own_name and (roster.agents != self._agents or lease.rank != self._lease.rank):
            self._wrong = roster.number
            return
        both = set(self._agents).intersection(roster.agents)
        if not self.number or (is_of_own_name and roster.number == self.number):
            return
        if self._lease.number and roster.swarm == self._swarm:
            if both and rank(roster) < rank(self._roster):
                self._give_up(self._lease.why_yield(roster))
        elif not is_of_own_name:
            why = f"{some(sorted(both))} also run in {roster.host}; stop one of the two hosts"
            self._host.guard.faults.set(f"roster of {roster.host}", why if both else "")
