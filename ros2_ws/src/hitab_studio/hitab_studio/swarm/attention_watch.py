"""What deserves a look in the connected swarm, and its machines."""

from __future__ import annotations

import time
from typing import Any

from hitab_client import MachineSigns, SwarmClient
from hitab_client.attention import Attention, Seen
from hitab_ros.timing import HEARTBEAT_S
from hitab_studio.swarm.processes import Processes
from hitab_studio.swarm.swarm_state import SwarmState


class AttentionWatch:
    """Ranks what deserves a look, from what the studio knows and its machines tell."""

    def __init__(self, agents: SwarmClient, processes: Processes) -> None:
        self._attention = Attention(processes.process_of)
        self._machines = MachineSigns(agents.link.node, agents.prefix, agents.identity)
        self._next = 0.0

    def look(self, known: SwarmState) -> dict[str, Any]:
        """Return the changes of the known state; to be called periodically."""
        if (now := time.monotonic()) < self._next:
            return {}
        self._next = now + HEARTBEAT_S
        scene, world = known.shown, known.world
        places = {}
        if scene is not None:
            places = dict(zip(scene.names, map(tuple, scene.places[:, :2].tolist()), strict=True))
        silent = self._machines.silent()
        seen = Seen(
            known.statuses,
            known.groups,
            {name: now - at for name, at in known.silent.items()},
            frozenset(world.missing if world is not None else ()) & known.statuses.keys(),
            places,
            now if scene is None else scene.seconds,
            self._machines.statuses(),
            silent,
        )
        since = {name: known.machines.get(name) or now - age for name, age in silent.items()}
        found = {
            "attention": tuple(self._attention.look(seen, now)),
            "machines": dict.fromkeys(self._machines.heard) | since,
            "machine_of": self._machines.machine_of(),
        }
        return {name: it for name, it in found.items() if it != getattr(known, name)}
