"""Waiting for commanders in lessons: they are not among those for whom the world waits.

An agent has perceived the world and acted before the next cycle. A commander perceives by what
its subordinates report, and acts by what they take up, a few messages later. A lesson that is to
give the same examples whenever it is played waits for both.
"""

from __future__ import annotations

from hitab_msgs.srv import ReadFeatures

from hitab_bringup import names
from hitab_bringup.command_view import CommandView
from hitab_bringup.swarm_client import SwarmClient
from hitab_ros.names import GROUP, READ_FEATURES

SEEN_SECONDS = 2.0
OBEYED_SECONDS = 2.0


class CommanderPacer:
    """Waits for the commanders of a swarm; for other agents there is nothing to wait for."""

    def __init__(self, swarm: SwarmClient) -> None:
        self._swarm = swarm
        self._view = CommandView(swarm.link, swarm.prefix, swarm.identity)

    def _is_commander(self, agent: str) -> bool:
        topic = names.of_agent(agent, GROUP, self._swarm.prefix)
        return bool(self._swarm.link.node.count_publishers(topic))

    def await_seen(self, agent: str, cycle: int) -> None:
        """Wait until all subordinates have told a commander what they perceive in a cycle.

        Those that are silent are not waited for longer than a while.
        """
        if not self._is_commander(agent):
            return

        def seen() -> bool:
            answer = self._swarm.ask(agent, ReadFeatures, READ_FEATURES)
            return bool(answer.cycle >= cycle)

        self._swarm.link.spin_until(seen, SEEN_SECONDS)

    def await_obeyed(self, agent: str) -> None:
        """Wait until all that a commander has heard of perform its order, or cannot now."""
        if not self._is_commander(agent):
            return
        self._view.await_groups(OBEYED_SECONDS, (agent,))
        self._swarm.link.spin_until(lambda: self._obeyed(agent), OBEYED_SECONDS)

    def _obeyed(self, agent: str) -> bool:
        group = self._view.groups.get(agent)
        path = self._swarm.statuses[agent].active_path
        if group is None or list(group.active_path) != list(path):
            return False
        return all(o or s for o, s in zip(group.obeying, group.silent, strict=True))
