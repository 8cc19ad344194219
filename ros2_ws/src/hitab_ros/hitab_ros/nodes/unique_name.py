"""Check that no two nodes have the same name, since both would obey every command."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import Any

from hitab_msgs.msg import Alive, HostRoster
from rclpy.duration import Duration
from rclpy.qos import QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from hitab_core import HitabError
from hitab_ros import names, qos
from hitab_ros.leases import NO_LEASE, Lease
from hitab_ros.nodes.definitions import check_same_message_version
from hitab_ros.nodes.guarded_node import GuardedNode
from hitab_ros.nodes.spinning import FinalError, Spinner
from hitab_ros.presence import ROSTERS
from hitab_ros.timing import CONNECT_S, FOUND_S

_PARTICIPANT = 12  # bytes of an endpoint's identifier that identify the process


class NameTakenError(FinalError):
    """Another node with the same name is up; restarting does not help."""


def check_name_is_free(
    spinning: Spinner,
    nodes: Sequence[GuardedNode],
    status: type[Any],
    observer: GuardedNode | None = None,
    lease: Lease = NO_LEASE,
) -> None:
    """Check for a while that no other process has a node of these names.

    Args:
        spinning: spinner to wait with, whose executor has the nodes.
        nodes: nodes about to join the swarm. None may have published a status yet.
        status: type of the messages on their status topics.
        observer: a host's node, below whose own namespace the swarm's topics are; None if there is
            one node, which then must have a publisher on its status topic.
        lease: a host's lease; the names that hosts with an older one have are free, since these
            yield.

    Raises:
        FinalError: if a host with a newer lease has one of the names, and gives signs of life.
        NameTakenError: if a name is taken; names the agent that is already up, and its swarm
            if that is another one. If two start at once, one of them gives way.
        HitabError: if a name is taken by a node of the same swarm.
        DefinitionsDifferError: if a node defines the project's messages differently.
    """
    # Other nodes with these names that are up: with the swarm of each, by name.
    established: dict[str, str] = {}
    observer = observer or nodes[0]
    named = {names.own_name(node): node for node in nodes}

    newer = dict[str, HostRoster]()
    living = set[str]()
    yielding = set[str]()

    def hear_roster(roster: HostRoster) -> None:
        both = named.keys() & set(roster.agents)
        if not lease.number or roster.swarm != _swarm_of(nodes[0]):
            established.update(dict.fromkeys(both, roster.swarm))
        elif both:
            theirs = Lease(roster.machine, roster.lease).rank
            if theirs < lease.rank:
                newer[roster.host] = roster
            elif theirs > lease.rank:
                yielding.update(both)
            else:
                established.update(dict.fromkeys(both, roster.swarm))

    topic = names.in_swarm(observer, names.HOSTS)
    rosters = observer.create_subscription(HostRoster, topic, hear_roster, ROSTERS, temporary=True)
    signs = observer.create_subscription(
        Alive,
        names.in_swarm(observer, names.ALIVE),
        lambda sign: living.add(sign.process) if lease.number else None,
        qos.SIGNS_OF_LIFE,
        temporary=True,
    )
    # The identifier of an endpoint that can only be this process's reveals its other endpoints.
    # Its random part is a setting without effect, since security policies allow no random names.
    lifespan = Duration(seconds=1 + secrets.randbelow(2**31 - 2))  # the range that DDS announces
    topic = names.in_swarm(observer, names.ALIVE)
    profile = QoSProfile(depth=1, lifespan=lifespan)
    marked = observer.create_publisher(Alive, topic, profile, temporary=True)
    spinning.spin_until(lambda: False, CONNECT_S)
    check_same_message_version(observer)
    ours = {
        _participant(end)
        for end in observer.get_publishers_info_by_topic(marked.topic_name)
        if end.qos_profile.lifespan == lifespan
    }
    observer.destroy_publisher(marked)
    if newer:  # it may be a leftover, or a stray message
        spinning.spin_until(lambda: not living.isdisjoint(newer), FOUND_S)
    observer.destroy_subscription(rosters)
    observer.destroy_subscription(signs)
    for host in newer.keys() & living:
        raise FinalError(lease.why_yield(newer[host]))
    for name, swarm in established.items():
        raise _taken(name, swarm, _swarm_of(named[name]))
    topics = {topic for topic, _ in observer.get_topic_names_and_types()}
    doubtful = [
        node
        for name, node in named.items()
        if name not in yielding and _status_of(node) in topics and _participants(node) - ours
    ]
    if not doubtful:
        return
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
        others = _participants(node) - ours
        # A host shows no status before it is up, so it cannot be the first of two.
        return min(others, default=ours_first) < ours_first if len(nodes) == 1 else bool(others)

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
    return {_participant(end) for end in node.get_publishers_info_by_topic(_status_of(node))}


def _status_of(node: GuardedNode) -> str:
    return f"{node.get_namespace().rstrip('/')}/{names.STATUS}"


def _participant(end: TopicEndpointInfo) -> bytes:
    return bytes(end.endpoint_gid)[:_PARTICIPANT]
