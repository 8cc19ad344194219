"""Signs of life of the processes that run the subordinates of a process's commanders."""

from __future__ import annotations

from collections.abc import Callable

from hitab_msgs.msg import Alive

from hitab_ros import GuardedNode, names, qos

Follow = Callable[[str], None]


class ProcessSigns:
    """Subscribes to signs of life once for all commanders of a process.

    Thousands of subordinates do not cost more messages than the processes that run them.
    """

    def __init__(self, node: GuardedNode) -> None:
        self._node = node
        self._followers: dict[str, dict[Follow, None]] = {}

    def follow(self, process: str, call: Follow) -> None:
        """Call a guarded function with the name of a process at each of its signs of life."""
        if not self._followers:
            topic = names.in_swarm(self._node, names.ALIVE)
            self._node.create_subscription(Alive, topic, self._hear, qos.SIGNS_OF_LIFE)
        self._followers.setdefault(process, {})[call] = None

    def _hear(self, sign: Alive) -> None:
        for call in self._followers.get(sign.process, ()):
            call(sign.process)
