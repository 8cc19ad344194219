"""What somebody did with an agent in a recording, moment by moment, without commands."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_client.errors import SwarmError
from hitab_client.recording.reading import agent_meant, opened
from hitab_core import Do, quantity
from hitab_core.showing import Moment
from hitab_ros import names
from hitab_ros.stamps import seconds_of

VELOCITY = "cmd_vel"
"""Topic of the velocity that a robot was driven with, in the agent's namespace."""

NANOSECONDS = 1e9
_PERCEPTS = (names.PERCEIVED, names.PERCEPT)


@dataclass(frozen=True)
class Driven:
    """What was done with one agent.

    Attributes:
        agent: its name.
        domain: the name of its domain.
        start: when the first percept was sent, s since 1970.
        moments: each cycle; they are so many s after the start.
    """

    agent: str
    domain: str
    start: float
    moments: list[Moment]


def driving_of(path: Path, agent: str = "") -> Driven:
    """Return what was done with an agent, whoever drove it.

    An agent, and whoever answers percepts in its place, publishes actions. A robot's are the
    velocities that its relay passed on, so that a person who drives by hand counts.

    Args:
        path: of the recording.
        agent: its name, with its namespace if there are several; empty: the only one.

    Raises:
        SwarmError: if it has no percepts of the agent, or nothing of what was done.
    """
    with opened(path) as messages:
        parts = {message.topic.rpartition("/") for message in messages}
    there = sorted({namespace for namespace, _, name in parts if name in _PERCEPTS})
    if not there:
        raise SwarmError(f"{path.name} has no percepts of any agent", Do.RECORD())
    namespace = agent_meant(path, there, agent)
    swarm, _, name = namespace.rpartition("/")
    world = f"{swarm}/{names.WORLD}"
    told = [f"{namespace}/{topic}" for topic in (*_PERCEPTS, VELOCITY, names.STATUS)]
    told += [f"{world}/{names.ACTIONS}", f"{world}/{names.STATUS}"]
    percepts: dict[int, tuple[float, Any]] = {}
    actions: dict[int, Any] = {}
    velocities: list[tuple[float, Any]] = []
    domain = ""
    with opened(path) as messages:
        for message in messages:
            if message.topic not in told:
                continue
            when, content = message.sent / NANOSECONDS, message.decoded()
            topic = message.topic.rpartition("/")[2]
            if topic in _PERCEPTS and not content.look:
                percepts.setdefault(content.sequence, (when, content))
            elif topic == names.ACTIONS and content.agent == name:
                actions[content.sequence] = content.values
            elif topic == VELOCITY:
                twist = getattr(content, "twist", content)
                velocities.append((when, (twist.linear.x, twist.linear.y, twist.angular.z)))
            elif message.topic == told[-1]:
                domain = domain or content.world  # who answers in its place has no status
            elif topic == names.STATUS:
                domain = content.domain
    seen = [percepts[sequence] for sequence in sorted(percepts)]
    did = [actions.get(percept.sequence) for _, percept in seen]
    if velocities:
        did = _driven([when for when, _ in seen], velocities)
    if not any(action is not None for action in did):
        raise SwarmError(
            f"{path.name} has {quantity(len(seen), 'percept')} of {name}, but not what was done: "
            f"it lacks its actions on {world}/{names.ACTIONS}, or of a robot {told[2]}",
            Do.RECORD(),
        )
    moments, episode = [], 0
    for (when, p), action in zip(seen, did, strict=True):
        episode += p.restart
        time, after = seconds_of(p.stamp), when - seen[0][0]
        moments.append(Moment(after, time, p.cycle, episode, p.values, p.heard, action))
    return Driven(name, domain, seen[0][0], moments)


def _driven(times: list[float], velocities: list[tuple[float, Any]]) -> list[Any]:
    """Return the last velocity before each next percept; None: there was none yet."""
    sent = [when for when, _ in velocities]
    before = [bisect_left(sent, end) - 1 for end in [*times[1:], sent[-1] + 1]]
    return [None if i < 0 else velocities[i][1] for i in before]
