"""What somebody did with an agent in a recording, moment by moment, without commands."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_client.errors import SwarmError
from hitab_client.recording.reading import opened
from hitab_core import Do, has, quantity
from hitab_core.showing import Moment
from hitab_ros import names, session_topics
from hitab_ros.stamps import seconds_of

VELOCITY = "cmd_vel"
"""Topic of the velocity that a robot was driven with, in the agent's namespace."""

NANOSECONDS = 1e9


@dataclass(frozen=True)
class Driven:
    """What was done with one agent.

    Attributes:
        agent: its name.
        domain: the name of its domain.
        start: when the first percept was recorded, s since 1970.
        moments: each cycle; they are so many s after the start.
    """

    agent: str
    domain: str
    start: float
    moments: list[Moment]


def driven_agents(path: Path) -> list[str]:
    """Return the agents, with their namespaces, of which a recording has percepts.

    Raises:
        SwarmError: if it cannot be read.
    """
    with opened(path) as messages:
        topics = {message.topic for message in messages}
    return sorted({t.rpartition("/")[0] for t in topics if _last(t) in _PERCEPTS})


def driving_of(path: Path, agent: str = "", told: Callable[[int], None] | None = None) -> Driven:
    """Return what was done with an agent, whoever drove it.

    An agent, and whoever answers percepts in its place, publishes actions. A robot's are the
    velocities that its relay passed on, so that a person who drives by hand counts.

    Args:
        path: of the recording.
        agent: its name, with its namespace if there are several; empty: the only one.
        told: is called with the number of messages that were read.

    Raises:
        SwarmError: if it has no percepts of the agent, or nothing of what was done.
    """
    there = driven_agents(path)
    found = [n for n in there if agent in ("", n, n.removeprefix("/"), n.rpartition("/")[2])]
    if not there:
        raise SwarmError(f"{path.name} has no percepts of any agent", Do.RECORD())
    if len(found) != 1:
        what = "has percepts of several agents" if found else f'has no percepts of "{agent}"'
        raise SwarmError(f"{path.name} {what}; choose one with --agent {has(there, agent)}")
    return _Reading(path, found[0], told).driven()


_PERCEPTS = (session_topics.PERCEIVED, names.PERCEPT)


def _last(topic: str) -> str:
    return topic.rpartition("/")[2]


class _Reading:
    """The messages of a recording that say what an agent perceived and did."""

    def __init__(self, path: Path, namespace: str, told: Callable[[int], None] | None) -> None:
        self._path, self._namespace = path, namespace
        self._agent = _last(namespace)
        self._percepts: dict[int, tuple[float, Any]] = {}
        self._actions: dict[int, Any] = {}
        self._velocities: list[tuple[float, tuple[float, ...]]] = []
        self._domain = self._world = ""
        own = {f"{namespace}/{name}" for name in (*_PERCEPTS, names.STATUS, VELOCITY)}
        swarm = namespace.rpartition("/")[0]
        world = {f"{swarm}/{names.WORLD}/{name}" for name in (names.ACTIONS, names.STATUS)}
        with opened(path) as messages:
            for done, message in enumerate(messages, 1):
                if message.topic in own | world:
                    self._take(message)
                if told is not None:
                    told(done)

    def _take(self, message: Any) -> None:
        name, content = _last(message.topic), message.decoded()
        when = message.received / NANOSECONDS
        if name in _PERCEPTS:
            if not content.look:
                self._percepts.setdefault(content.sequence, (when, content))
        elif name == names.ACTIONS:
            if content.agent == self._agent:
                self._actions[content.sequence] = content.values
        elif name == VELOCITY:
            twist = getattr(content, "twist", content)
            self._velocities.append((when, (twist.linear.x, twist.linear.y, twist.angular.z)))
        elif hasattr(content, "world"):
            self._world = content.world
        else:
            self._domain = content.domain

    def driven(self) -> Driven:
        """Return what was done."""
        percepts = sorted(self._percepts.values(), key=lambda one: one[1].sequence)
        did = self._did(percepts)
        if all(action is None for action in did):
            wanted = f"{names.WORLD}/{names.ACTIONS}, or of a robot {self._namespace}/{VELOCITY}"
            raise SwarmError(
                f"{self._path.name} has {quantity(len(percepts), 'percept')} of {self._agent}, "
                f"but not what was done: it lacks its actions on the topic {wanted}",
                Do.RECORD(),
            )
        moments, episode, start = [], 0, percepts[0][0]
        for (when, percept), action in zip(percepts, did, strict=True):
            episode += percept.restart
            moments.append(
                Moment(
                    when - start,
                    seconds_of(percept.stamp),
                    percept.cycle,
                    episode,
                    percept.values,
                    percept.heard,
                    action,
                )
            )
        return Driven(self._agent, self._domain or self._world, start, moments)

    def _did(self, percepts: list[tuple[float, Any]]) -> list[Any]:
        """Return the action after each percept; None: not known."""
        if not self._velocities:
            return [self._actions.get(percept.sequence) for _, percept in percepts]
        times = [when for when, _ in self._velocities]
        ends = [when for when, _ in percepts[1:]] + [times[-1] + 1]
        before = [bisect_left(times, end) - 1 for end in ends]
        return [None if i < 0 else self._velocities[i][1] for i in before]
