"""Listener to all that shows what deserves a look in a swarm."""

from __future__ import annotations

import time

from hitab_msgs.msg import MachineStatus

from hitab_client.attention.attention import Attention, Seen
from hitab_client.attention.items import Item
from hitab_client.showing.agent_presence import AgentPresence
from hitab_client.showing.commander_view import CommanderView
from hitab_client.world_client import WorldClient
from hitab_ros import Presence, names, qos
from hitab_ros.leases import machine_rank
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.timing import HEARTBEAT_S

MACHINES_MAX = 1000
"""Maximum number of machines, whatever is received."""


class Machines:
    """The machines of a swarm that have given signs of life.

    Attributes:
        statuses: last status of each machine, by name.
    """

    def __init__(self, agents: AgentPresence) -> None:
        """Listen to the machines of the swarm of these agents from now on."""
        self.statuses: dict[str, MachineStatus] = {}
        self._presence = Presence()
        self._swarm = agents.identity
        topic = names.of_swarm(names.MACHINES, agents.prefix)
        agents.link.subscribe(MachineStatus, topic, self._take, qos.SIGNS_OF_LIFE)

    def silent(self) -> dict[str, float]:
        """Return the silent machines with the time since the last sign, s."""
        return self._presence.silent()

    def machine_of(self) -> dict[str, str]:
        """Return the machine that has each agent and commander."""
        claims = [
            (machine_rank(name, process), name, process.agents)
            for name, status in self.statuses.items()
            for process in status.processes
        ]
        claims.sort(key=lambda claim: claim[0], reverse=True)
        return {agent: machine for _, machine, agents in claims for agent in agents}

    def _take(self, status: MachineStatus) -> None:
        known = status.machine in self.statuses or len(self.statuses) < MACHINES_MAX
        if known and self._swarm in ("", status.swarm):
            self.statuses[status.machine] = status
            self._presence.hear(status.machine)


class AttentionListener:
    """Hears a whole swarm, and says what deserves a look."""

    def __init__(self, agents: AgentPresence, world: WorldClient, *, has_world: bool) -> None:
        """Listen from now on.

        Args:
            agents: the agents of the swarm.
            world: its world.
            has_world: whether the swarm has started a world.
        """
        agents.watch_all()
        self._agents = agents
        self._world = world
        self._commanders = CommanderView(agents)
        self._signs = agents.signs_of_life(has_world=has_world)
        self._machines = Machines(agents)
        self._attention = Attention(agents.processes.process_of)
        self._next_look = 0.0

    def discover(self) -> None:
        """Find agents and commanders that have joined; call this periodically."""
        self._agents.discover()
        self._commanders.discover()

    def look(self) -> list[Item]:
        """Return what deserves a look, the most important first; call this periodically."""
        if (now := time.monotonic()) < self._next_look:
            return self._attention.items
        self._next_look = now + HEARTBEAT_S
        agents, state = self._agents, self._world.state
        self._signs.hear_known(agents.news)
        agents.news.clear()
        seen = Seen(
            agents.statuses,
            self._commanders.groups,
            self._signs.silent(),
            frozenset(self._world.missing) & agents.statuses.keys(),
            {} if state is None else {it.name: (it.x, it.y) for it in state.entities},
            now if state is None else seconds_of(state.header.stamp),
            self._machines.statuses,
            self._machines.silent(),
        )
        return self._attention.look(seen, now)
