"""Signs of life of a swarm's processes, and the agents that are silent."""

from __future__ import annotations

import time
from collections.abc import Collection, Iterable

from hitab_msgs.msg import Alive, HostRoster
from rclpy.qos import QoSProfile

from hitab_client.identity import is_own
from hitab_client.ros_link import RosLink
from hitab_ros import names, qos

SILENT_AFTER_SECONDS = 1.5
"""Time without a sign after which a process is silent, s; signs come twice a second."""

GAP_SECONDS = 0.25
"""A longer time between two checks, s, is not counted: then this process was held up."""

PROCESSES_MAX = 5000

ROSTERS = QoSProfile(
    depth=PROCESSES_MAX, reliability=qos.LATCHED.reliability, durability=qos.LATCHED.durability
)


class SignsOfLife:
    """Silent agents of a swarm, and whether its world is silent.

    An agent is silent if all of its processes are silent, and no message of the agent arrives: a
    slow process sends its signs late, but its messages show that it is alive. If a process has
    never sent a sign, for example because it is written in another language, its agents are never
    silent.

    Args:
        link: the node to use.
        expected: names of the started agents, and `names.WORLD` if the swarm has a world.
        prefix: namespace of the swarm.
        identity: the swarm's identity; empty for any swarm.
    """

    def __init__(
        self,
        link: RosLink,
        expected: Collection[str] = (),
        *,
        prefix: str = "",
        identity: str = "",
    ) -> None:
        self._expected = frozenset(expected)
        self._identity = identity
        self._heard: dict[str, float] = {}  # time of each process's last sign
        self._shown: dict[str, float] = {}  # time of other messages, by name
        self._members: dict[str, frozenset[str]] = {}  # by host
        self._listened = 0.0
        self._last_look = time.monotonic()
        link.subscribe(HostRoster, names.of_swarm(names.HOSTS, prefix), self._take_roster, ROSTERS)
        link.subscribe(
            Alive, names.of_swarm(names.ALIVE, prefix), self._take_sign, qos.SIGNS_OF_LIFE
        )

    def _is_own(self, name: str, swarm: str) -> bool:
        return is_own(swarm, self._identity, started_by_it=name in self._expected)

    def _take_roster(self, roster: HostRoster) -> None:
        known = self._members.get(roster.host, frozenset())
        if (known or len(self._members) < PROCESSES_MAX) and self._is_own("", roster.swarm):
            self._members[roster.host] = known | frozenset(roster.agents)

    def _take_sign(self, sign: Alive) -> None:
        for name in (sign.process, *sign.agents):
            known = name in self._heard or len(self._heard) < PROCESSES_MAX
            if known and self._is_own(name, sign.swarm):
                self._heard[name] = self._time()

    def take_signs_of(self, these: Iterable[str]) -> None:
        """Count other messages, just received from agents or the world, as signs of life."""
        now = self._time()
        self._shown |= dict.fromkeys(these, now)

    def _time(self) -> float:
        """Return the time for which this process has listened, s."""
        now = time.monotonic()
        self._listened += min(now - self._last_look, GAP_SECONDS)
        self._last_look = now
        return self._listened

    def silent(self) -> dict[str, float]:
        """Return the silent agents, and the world if silent, with the time since the last sign, s.

        Call this several times a second, and spin the link in between.
        """
        now = self._time()
        heard: dict[str, float] = {}
        for process, moment in self._heard.items():
            for name in self._members.get(process, (process,)):
                heard[name] = max(heard.get(name, moment), moment, self._shown.get(name, moment))
        return {name: now - at for name, at in heard.items() if now - at > SILENT_AFTER_SECONDS}
