"""Check that no two nodes have the same name, since both would obey every command."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import Any

from hitab_msgs.msg import Alive
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from hitab_core import HitabError
from hitab_ros import names, qos
from hitab_ros.nodes.definitions import check_same_message_version
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.spinning import FinalError, Spinner
from hitab_ros.timing import CONNECT_S, FOUND_S

_PARTICIPANT = 12  # bytes of an endpoint's identifier that identify the process


class NameTakenError(FinalError):
    """Another node with the same name is up; restarting does not help."""


def check_name_is_free(spinning: Spinner, nodes: Sequence[GuardedNode], status: type[Any]) -> None:
    """Check for a while that no other process has a node of these names.

    Args:
        spinning: spinner to wait with, whose executor has the nodes.
        nodes: nodes about to join the swarm. Each must have a publisher on its status topic but
            must not have published yet.
        status: type of the messages on that topic.

    Raises:
        NameTakenError: if a name is taken; names the agent that is already up, and its swarm
            if that is another one. If two start at once, one of them gives way.
        HitabError: if a name is taken by a node of the same swarm.
        DefinitionsDifferError: if a node defines the project's messages differently.
    """
    # The identifier of an endpoint that can only be this process's reveals its other endpoints.
    # Its random part is a setting without effect, since security policies allow no random names.
    lifespan = Duration(seconds=1 + secrets.randbelow(2**31 - 2))  # the range that DDS announces
    topic = names.in_swarm(nodes[0], names.ALIVE)
    profile = QoSProfile(depth=1, lifespan=lifespan)
    marked = nodes[0].create_publisher(Alive, topic, profile, temporary=True)
    spinning.spin_until(lambda: False, CONNECT_S)
    check_same_message_version(nodes[0])
    ours = {
        _participant(end)
        for end in nodes[0].get_publishers_info_by_topic(marked.topic_name)
        if end.qos_profile.lifespan == lifespan
    }
    nodes[0].destroy_publisher(marked)
    doubtful = {node: others for node in nodes if (others := _participants(node) - ours)}
    if not doubtful:
        return
    # Other nodes with these names that have published a status were up first.
    established: dict[str, str] = {}  # with the swarm of each, by name
    listeners = []
    for node in doubtful:
        name = names.own_name(node)

        def hear(message: Any, name: str = name) -> None:
            established[name] = message.swarm

        listener = node.create_subscription(
            status, names.STATUS, hear, qos.LATCHED, temporary=True
        )
        listeners.append((node, listener))

    def undecided(node: GuardedNode) -> bool:
        if names.own_name(node) in established:
            return False
        return min(_participants(node) - ours, default=ours_first) < ours_first

    ours_first = min(ours)
    try:
        spinning.spin_until(lambda: len(established) == len(doubtful), CONNECT_S)
        # Of two that start at once, the one with the lower identifier continues, and the other
        # receives its status. A node that never publishes was killed; its leftovers do not
        # count.
        spinning.spin_until(lambda: not any(map(undecided, doubtful)), FOUND_S)
        for node in doubtful:
            if (name := names.own_name(node)) in established:
                raise _taken(name, established[name], _swarm_of(node))
    finally:
        for node, listener in listeners:
            node.destroy_subscription(listener)


def _taken(name: str, other: str, own: str) -> HitabError:
    where = f"swarm {other}, in the same ROS domain" if other not in ("", own) else "this swarm"
    # Leftovers of the same swarm may be gone at the next try.
    kind = HitabError if own and other == own else NameTakenError
    return kind(
        f'"{name}" is already running in {where}; give this one another name, or stop the '
        "other one"
    )


def _swarm_of(node: GuardedNode) -> str:
    return str(node.get_parameter("swarm").value) if node.has_parameter("swarm") else ""


def _participants(node: GuardedNode) -> set[bytes]:
    """Return the processes that publish a status in a node's namespace."""
    topic = f"{node.get_namespace().rstrip('/')}/{names.STATUS}"
    return {_participant(end) for end in node.get_publishers_info_by_topic(topic)}


def _participant(end: TopicEndpointInfo) -> bytes:
    return bytes(end.endpoint_gid)[:_PARTICIPANT]
