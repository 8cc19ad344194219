"""Refusing to run two nodes of one name, which would both answer to every command."""

from __future__ import annotations

import uuid
from collections.abc import Sequence
from typing import Any

from rclpy.node import Node

from hitab_core.errors import HitabError
from hitab_ros import names, qos
from hitab_ros.spinning import Spinner

DISCOVERY_S = 0.7
"""How long to look for others; nodes on the same machine find each other well within this."""

DEAD_AFTER_S = 2.5
"""How long one that was found is given to say something; killed ones are found for longer."""

_PARTICIPANT = 12  # bytes of an endpoint's identifier that tell the process


def refuse_second_of_name(spinning: Spinner, nodes: Sequence[Node], status: type[Any]) -> None:
    """Look around for a while and make sure that no other process has these names.

    Args:
        spinning: to wait with; the nodes have been added to its executor.
        nodes: which are about to join the swarm. Each has a publisher on its status topic by
            now but has published nothing yet.
        status: type of the messages on that topic.

    Raises:
        HitabError: naming the agent that is there already. Where two start at once, one of them
            gives way.
    """
    # The identifier of an endpoint that can only be ours tells which of the others are.
    marker_topic = f"marker_{uuid.uuid4().hex}"
    marker = nodes[0].create_publisher(status, marker_topic, 1)
    spinning.spin_until(lambda: False, DISCOVERY_S)
    ours = _participants(nodes[0], marker_topic)
    nodes[0].destroy_publisher(marker)
    doubtful = {node: others for node in nodes if (others := _participants(node) - ours)}
    if not doubtful:
        return
    # Somebody has these names, too: who has published its status was there before.
    established: set[str] = set()
    listeners = []
    for node in doubtful:
        name = names.own_name(node)

        def hear(message: Any, name: str = name) -> None:
            established.add(name)

        listeners.append((node, node.create_subscription(status, names.STATUS, hear, qos.LATCHED)))

    def undecided(node: Node) -> bool:
        if names.own_name(node) in established:
            return False
        return min(_participants(node) - ours, default=ours_first) < ours_first

    ours_first = min(ours)
    try:
        spinning.spin_until(lambda: len(established) == len(doubtful), DISCOVERY_S)
        # Of two that start at once the first by identifier goes on, and the other will hear it.
        # Whoever is not heard at all was killed: what it left behind is no reason to give way.
        spinning.spin_until(lambda: not any(map(undecided, doubtful)), DEAD_AFTER_S)
        for name in sorted(established):
            raise HitabError(
                f'"{name}" is running already in this swarm; '
                "give this one another name, or stop the other one"
            )
    finally:
        for node, listener in listeners:
            node.destroy_subscription(listener)


def _participants(node: Node, topic: str = names.STATUS) -> set[bytes]:
    """Return the processes that publish on a topic of a node's namespace."""
    full = f"{node.get_namespace().rstrip('/')}/{topic}"
    found = node.get_publishers_info_by_topic(full)
    return {bytes(info.endpoint_gid)[:_PARTICIPANT] for info in found}
