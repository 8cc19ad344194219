"""Listener to the nodes of one swarm."""

from __future__ import annotations

from collections.abc import Collection

from hitab_client.connecting.identity import is_own, other_swarm
from hitab_client.connecting.ros_link import RosLink


class SwarmListener:
    """Listens to the nodes of one swarm, and notes those of other swarms.

    Args:
        link: the node to use.
        prefix: namespace of the swarm.
        identity: the swarm's identity; empty for any swarm.
        started: names of the nodes that the swarm has started.

    Attributes:
        strangers: the swarm of each node that belongs to another swarm, by name; empty for a node
            started by hand.
    """

    def __init__(
        self, link: RosLink, prefix: str, identity: str, started: Collection[str] = ()
    ) -> None:
        self.link = link
        self.prefix = prefix
        self.identity = identity
        self.strangers: dict[str, str] = {}
        self._started = started

    def _is_own(self, name: str, owner: str) -> bool:
        """Return whether a node belongs to the swarm, and note it otherwise.

        Args:
            name: name of the node.
            owner: identity in the node's status.
        """
        own = is_own(owner, self.identity, started_by_it=name in self._started)
        if own:
            self.strangers.pop(name, None)
        else:
            self.strangers[name] = owner
        return own

    def refuse_strangers(self, wanted: Collection[str]) -> None:
        """Check that none of these nodes is known to belong to another swarm.

        Raises:
            SwarmError: if one does; names both swarms.
        """
        for name in self.strangers:
            if name in wanted:
                raise other_swarm(name, self.strangers[name], self.identity)
