"""Follows every change of agents' active states, so that no short-lived state is missed.

An agent's status has its active states too, but only at intervals; its transitions report every
change, with the world's cycle.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Self

from hitab_msgs.msg import TransitionEvent

from hitab_client.ros_link import RosLink
from hitab_ros import names, qos


class PathTracker:
    """The active states of some agents; a context manager, since following costs the agents time.

    Args:
        link: the node to use.
        agents: to follow.
        prefix: namespace of the swarm.
    """

    def __init__(self, link: RosLink, agents: Iterable[str], *, prefix: str = "") -> None:
        self._link = link
        self._topics = {a: names.of_agent(a, names.TRANSITIONS, prefix) for a in agents}
        self._passed: dict[str, list[str]] = {agent: [] for agent in self._topics}

    def __enter__(self) -> Self:
        self._subscriptions = [
            self._link.subscribe(TransitionEvent, topic, self._take, qos.EVENTS, temporary=True)
            for topic in self._topics.values()
        ]
        count = self._link.node.count_publishers
        self._link.spin_until(lambda: all(count(t) for t in self._topics.values()), 3.0, 0.01)
        return self

    def __exit__(self, *error: object) -> None:
        for subscription in self._subscriptions:
            self._link.node.destroy_subscription(subscription)

    def _take(self, event: TransitionEvent) -> None:
        self._passed[event.agent].append(event.to_state)

    def take(self) -> dict[str, list[str]]:
        """Return the states that each agent entered since the last call."""
        taken = self._passed
        self._passed = {agent: [] for agent in self._topics}
        return taken
