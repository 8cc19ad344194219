"""Listener to all that shows what deserves a look in a swarm."""

from __future__ import annotations

import time

from hitab_client.attention.attention import Attention, Seen
from hitab_client.attention.items import Item
from hitab_client.showing.agent_presence import AgentPresence
from hitab_client.showing.commander_view import CommanderView
from hitab_client.showing.machine_signs import MachineSigns
from hitab_client.world_client import WorldClient
from hitab_ros.messages.stamps import seconds_of
from hitab_ros.timing import HEARTBEAT_S


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
        self._machines = MachineSigns(agents.link.node, agents.prefix, agents.identity)
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
            self._machines.statuses(),
            self._machines.silent(),
        )
        return self._attention.look(seen, now)
