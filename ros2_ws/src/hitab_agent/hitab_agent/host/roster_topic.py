"""The topic on which a host publishes which agents it runs, and sees which others do."""

from __future__ import annotations

import time
from collections.abc import Sequence

from hitab_msgs import msg

from hitab_agent.node.agent_base import AgentBase
from hitab_core import some
from hitab_ros import GuardedNode, HostRosters, NameTakenError, names, qos


class RosterTopic:
    """Publishes a host's roster, and gives way to another host that runs one of its agents.

    Two hosts that start at once do not see each other's rosters before they publish their own, so
    the one that published later ends.

    Attributes:
        number: number of the last published roster; 0 before the first.
        others: the rosters of all hosts.
    """

    def __init__(self, host: GuardedNode, nodes: Sequence[AgentBase], swarm: str) -> None:
        """Create the publisher.

        Args:
            host: a node of the host, in its own namespace.
            nodes: the nodes of all its agents.
            swarm: identity of the agents' swarm; empty if none.
        """
        self.number = 0
        self._name = names.own_name(host)
        self._nodes = nodes
        self._swarm = swarm
        self._other = ""
        topic = names.in_swarm(host, names.HOSTS)
        self.others = HostRosters(host, topic, changed=self._hear)
        self._publisher = host.create_publisher(msg.HostRoster, topic, qos.LATCHED)

    def publish(self, after: int = 0) -> None:
        """Publish the roster with a higher number than any before, and than another one."""
        # The number is the time of day, so that a restarted host has a higher one.
        self.number = max(time.time_ns(), self.number + 1, after + 1)
        agents = [node.agent_name for node in self._nodes]
        self._publisher.publish(
            msg.HostRoster(host=self._name, number=self.number, agents=agents, swarm=self._swarm)
        )

    def _hear(self, roster: msg.HostRoster) -> None:
        if not 0 < roster.number < self.number:
            return
        both = {node.agent_name for node in self._nodes}.intersection(roster.agents)
        if both:
            self._other = f'{some(sorted(both))} already run in the host "{roster.host}"'

    def refuse_others(self) -> None:
        """Check that no host that was up before runs one of the agents.

        Raises:
            NameTakenError: if one does.
        """
        if self._other:
            raise NameTakenError(f"{self._other}; stop one of the two hosts")
