"""Presence: who gives signs of life, who is silent, and who has gone.

Each process gives signs of life, and `Presence` records the last sign of each name. All silences
are measured by `ListenedTime`, so that a process that was starved or suspended does not take
others for silent. Others drop a process that stood still for too long; `suspensions_noticed`
notices this in the process itself, which then has to be started again.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from typing import Any
from xml.etree import ElementTree

from hitab_msgs.msg import Alive, HostRoster
from rclpy.node import Node
from rclpy.qos import QoSProfile

from hitab_ros import names, qos
from hitab_ros.leases import holders, is_later
from hitab_ros.nodes.steady_timer import steady_timer
from hitab_ros.timing import HEARTBEAT_S, POLL_S, SILENT_AFTER_S

DDS_PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"

NAMES_MAX = 100_000
"""Maximum number of names in a `Presence`, whatever is received."""

HOSTS_MAX = 5000

Fill = Callable[[Alive], object]

ROSTERS = QoSProfile(
    depth=HOSTS_MAX, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
)


class ListenedTime:
    """Clock that runs only while its process listens.

    Args:
        gap_s: maximum time between two readings that counts, s: in a longer one, the process was
            held up, and did not receive what others sent. At least the period of the readings.
    """

    def __init__(self, gap_s: float = POLL_S) -> None:
        self._gap_s = gap_s
        self._listened_s = 0.0
        self._read_at = time.monotonic()

    def now(self) -> float:
        """Return the time for which this process has listened, s; call this periodically."""
        now = time.monotonic()
        self._listened_s += min(now - self._read_at, self._gap_s)
        self._read_at = now
        return self._listened_s


class Presence:
    """The last sign of each name.

    A name is silent if it gave a sign once and none for a while, or if it has gone. A name that
    never gave a sign is not silent: it may still start, or be of a program that gives none.

    Args:
        silent_after_s: time without a sign after which a name is silent, s.
        gap_s: see `ListenedTime`.

    Attributes:
        last_signs: time of each name's last sign, s of listening.
    """

    def __init__(self, silent_after_s: float = SILENT_AFTER_S, gap_s: float = POLL_S) -> None:
        self.last_signs: dict[str, float] = {}
        self._silent_after_s = silent_after_s
        self._time = ListenedTime(gap_s)
        self._gone: dict[str, float] = {}  # with the time at which this was noticed

    def hear(self, name: str, due_in_s: float = 0.0) -> None:
        """Take a sign of a name.

        Args:
            name: who gave the sign.
            due_in_s: time until which no other sign is due, s, such as for a start.
        """
        if name in self.last_signs or len(self.last_signs) < NAMES_MAX:
            self.last_signs[name] = self._time.now() + due_in_s

    def hear_known(self, others: Iterable[str]) -> None:
        """Take other messages as signs of names that gave signs before."""
        for name in self.last_signs.keys() & set(others):
            self.hear(name)

    def set_gone(self, gone: Iterable[str]) -> None:
        """Set the names that have gone: those whose node has left the ROS graph."""
        now = self._time.now()
        self._gone = {name: self._gone.get(name, now) for name in gone}

    def age(self, name: str) -> float:
        """Return the time since the last sign of a name, s; infinite before the first."""
        return self._time.now() - self.last_signs.get(name, -float("inf"))

    def listen(self) -> None:
        """Take the time into account; to be called periodically, unless `silent` is."""
        self._time.now()

    def misses(self, name: str) -> bool:
        """Whether this has listened for long enough, and heard no sign of a name meanwhile."""
        return self._time.now() - self.last_signs.get(name, 0.0) > self._silent_after_s

    def silent(self) -> dict[str, float]:
        """Return the silent names with the time since the last sign, s; call this periodically."""
        now = self._time.now()
        found = {name: now - at for name, at in self._gone.items()}
        for name, at in self.last_signs.items():
            if now - at > self._silent_after_s or name in found:
                found[name] = now - at
        return found


class HostRosters:
    """Rosters of a swarm's hosts: which process runs an agent or commander.

    Where leases count, a roster takes agents away, so it counts from the first sign of life of
    its host on: not if it is the leftover of one that was lost, or a stray message.

    Args:
        node: node to subscribe with.
        topic: full name of the topic of rosters.
        accept: whether a roster is of the swarm; by default, all are.
        leases: whether leases count, as in a swarm on several machines.

    Attributes:
        changed: functions that are called with each accepted roster.
        rosters: the roster in force of each host, by host.
        hosts_of: the hosts that hold each agent and commander, by name; see `leases.holders`.
            Several without leases, if a roster is wrong, or the same agent runs twice.
        leases: whether leases count.
    """

    def __init__(
        self,
        node: Node,
        topic: str,
        accept: Callable[[HostRoster], bool] = lambda roster: True,
        *,
        leases: bool = False,
    ) -> None:
        self.leases = leases
        self.rosters: dict[str, HostRoster] = {}
        self.hosts_of: dict[str, tuple[str, ...]] = {}
        self._listing: dict[str, set[str]] = {}  # the hosts that list each name
        self._accept = accept
        self.changed: list[Callable[[HostRoster], object]] = []
        self._unconfirmed: dict[str, HostRoster] = {}
        hear = self._hear if leases else self._hear_without_lease
        node.create_subscription(HostRoster, topic, hear, ROSTERS)
        if leases:
            alive = f"{topic.removesuffix(names.HOSTS)}{names.ALIVE}"
            node.create_subscription(Alive, alive, self._hear_sign, qos.SIGNS_OF_LIFE)

    def _hear_without_lease(self, roster: HostRoster) -> None:
        roster.lease, roster.machine = 0, ""
        if self._is_news(roster, self.rosters):
            self._take(roster)

    def _hear(self, roster: HostRoster) -> None:
        if self._is_news(roster, self.rosters) and self._is_news(roster, self._unconfirmed):
            self._unconfirmed[roster.host] = roster

    def _hear_sign(self, sign: Alive) -> None:
        roster = self._unconfirmed.get(sign.process)
        if roster is not None and roster.swarm == sign.swarm:
            self._take(self._unconfirmed.pop(sign.process))

    def _is_news(self, roster: HostRoster, among: dict[str, HostRoster]) -> bool:
        known = among.get(roster.host)
        is_later_one = len(among) < HOSTS_MAX if known is None else is_later(roster, known)
        return is_later_one and self._accept(roster)

    def _take(self, roster: HostRoster) -> None:
        host, known = roster.host, self.rosters.get(roster.host)
        self.rosters[host] = roster
        for name in known.agents if known is not None else ():
            self._listing[name].discard(host)
        for name in roster.agents:
            self._listing.setdefault(name, set()).add(host)
        for name in {*roster.agents, *(known.agents if known is not None else ())}:
            listing = holders(self.rosters[other] for other in self._listing[name])
            self.hosts_of[name] = tuple(other.host for other in listing)
        for changed in self.changed:
            changed(roster)

    def believes(self, process: str, name: str) -> bool:
        """Whether reports and signs of a process count for an agent or commander.

        If it has a lease, those of its holder do; else all, since a wrong roster may be corrected.
        """
        hosts = self.hosts_of.get(name, ())
        return process in hosts or not (hosts and self.rosters[hosts[0]].lease)

    def speaks_for(self, process: str) -> Iterator[str]:
        """Yield the agents and commanders that a process gives signs of life for."""
        roster = self.rosters.get(process)
        for name in (process,) if roster is None else roster.agents:
            if self.believes(process, name):
                yield name


class SignsOfLife(Presence):
    """Presence of a swarm's agents, commanders and world, by their processes' signs of life.

    A host gives signs for all of its agents. A slow process gives signs late, so tell `hear_known`
    of the other messages. Spin the node between two calls of `silent`.

    Args:
        node: the node to use.
        prefix: namespace of the swarm.
        is_own: returns whether a process belongs to the swarm, given its name, empty for a host,
            and the identity of its swarm.
        leases: whether the swarm is on several machines.
    """

    def __init__(
        self,
        node: Node,
        prefix: str,
        is_own: Callable[[str, str], bool],
        *,
        leases: bool = False,
    ) -> None:
        super().__init__()
        self._is_own = is_own
        rosters, alive = (names.of_swarm(name, prefix) for name in (names.HOSTS, names.ALIVE))
        self._rosters = HostRosters(
            node, rosters, lambda roster: is_own("", roster.swarm), leases=leases
        )
        self._rosters.changed.append(self._is_host)
        node.create_subscription(Alive, alive, self._take_sign, qos.SIGNS_OF_LIFE)

    def _is_host(self, roster: HostRoster) -> None:
        if roster.host not in roster.agents:
            self.last_signs.pop(roster.host, None)

    def _take_sign(self, sign: Alive) -> None:
        if self._is_own(sign.process, sign.swarm):
            for name in self._rosters.speaks_for(sign.process):
                self.hear(name)


def give_signs_of_life(node: Node, swarm: str = "", fill: Fill = lambda sign: None) -> None:
    """Publish signs of life from now on, in the name of a node's agent, host or world.

    Signs come from the thread that handles the node's other events, so a process that hangs in an
    event sends none. Without a subscriber nothing is sent.

    Args:
        node: node that represents its process; the last part of its namespace is the name.
        swarm: identity of the node's swarm, or empty.
        fill: called with each sign before it is sent, to complete it.
    """
    sign = Alive(process=names.own_name(node), swarm=swarm)
    _give(node, names.in_swarm(node, names.ALIVE), sign, lambda: True, fill)


def give_signs_of_operator(node: Node, prefix: str, is_present: Callable[[], object]) -> None:
    """Publish from now on that an operator of a swarm's agents is present.

    Args:
        node: node of the operator's console.
        prefix: namespace of the swarm.
        is_present: returns whether the operator is in reach of the console.
    """
    topic = names.of_swarm(names.OPERATORS, prefix)
    _give(node, topic, Alive(process=node.get_name()), is_present)


def _give(
    node: Node,
    topic: str,
    sign: Alive,
    is_present: Callable[[], object],
    fill: Fill = lambda sign: None,
) -> None:
    publisher = node.create_publisher(Alive, topic, qos.SIGNS_OF_LIFE)

    def show() -> None:
        if is_present():
            fill(sign)
            publisher.publish(sign)

    steady_timer(node, HEARTBEAT_S, show)  # by the machine's clock: a paused world is alive, too


class Receivers:
    """Receivers of a publisher.

    Their number alone does not show that a new receiver has replaced another, as when a restarted
    process appears at the moment at which its killed predecessor is dropped.

    Args:
        node: node of the publisher.
        publisher: publisher from which they receive.

    Attributes:
        count: number of connected receivers at the last look.
    """

    def __init__(self, node: Node, publisher: Any) -> None:
        self.count = 0
        self._node = node
        self._publisher = publisher
        self._ends: frozenset[bytes] = frozenset()

    def look(self) -> bool:
        """Update the receivers; return whether one of them is new.

        A killed process is dropped long after its successor has started; this is not a change.
        """
        count, ends = self.count, self._ends
        found = self._node.get_subscriptions_info_by_topic(self._publisher.topic_name)
        # A receiver may be discovered before it is connected, so both are compared.
        self._ends = frozenset(bytes(end.endpoint_gid) for end in found)
        self.count = self._publisher.get_subscription_count()
        return self.count > count or not self._ends <= ends


def _remembered_s() -> float:
    """Return the time for which others remember a process that stands still, s."""
    lease_s = 20.0  # default of Fast DDS
    with contextlib.suppress(KeyError, OSError, ElementTree.ParseError, ValueError):
        root = ElementTree.parse(os.environ[DDS_PROFILE]).getroot()
        lease_s = float(root.findtext(".//{*}leaseDuration/{*}sec") or lease_s)
    return 0.8 * lease_s  # the last announcement may be a fifth of the lease old


@contextlib.contextmanager
def suspensions_noticed(tell: Callable[[float], None]) -> Iterator[None]:
    """Call a function, in a thread, with the duration of each long suspension, s.

    A participant that only one side has dropped is not fully rediscovered: if a heartbeat arrives
    before the first request for earlier samples, Fast DDS 2.14 takes all of them for received.
    """
    longest, over = _remembered_s(), threading.Event()

    def watch() -> None:
        before = time.monotonic()
        while not over.wait(longest / 20.0):
            now = time.monotonic()
            if now - before > longest:
                tell(now - before)
            before = now

    thread = threading.Thread(target=watch, daemon=True)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
