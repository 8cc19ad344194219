"""The actions of an agent in a recording, moment by moment, without commands."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_client.errors import SwarmError
from hitab_client.recording.reading import RecordedMessages, agent_meant
from hitab_core import Fix, quantity
from hitab_core.labeling import ShownAction
from hitab_ros import names
from hitab_ros.stamps import seconds_of

VELOCITY_TOPIC = "cmd_vel"
"""Topic of the velocity that a robot was driven with, in the agent's namespace."""

NANOSECONDS = 1e9
_PERCEPTS = (names.PERCEIVED, names.PERCEPT)


@dataclass(frozen=True)
class Driven:
    """Actions of one agent.

    Attributes:
        agent: its name.
        domain: the name of its domain.
        start: when the first percept was recorded, s since 1970.
        moments: each cycle; they are so many s after the start.
        missing: what an unfinished recording lacks; "" if nothing.
    """

    agent: str
    domain: str
    start: float
    moments: list[ShownAction]
    missing: str


def driving_of(path: Path, agent: str = "") -> Driven:
    """Return the actions of an agent, from any driver.

    An agent, or a program that answers percepts in its place, publishes actions. A robot's are the
    velocities that its relay passed on, so that a person who drives by hand counts.

    Args:
        path: of the recording.
        agent: its name, with its namespace if there are several; empty for the only one.

    Raises:
        SwarmError: if the recording lacks percepts or actions of the agent.
    """
    messages = RecordedMessages(path)
    parts = {message.topic.rpartition("/") for message in messages}
    there = sorted({namespace for namespace, _, name in parts if name in _PERCEPTS})
    if not there:
        raise SwarmError(f"{path.name} has no percepts of any agent", Fix.RECORD())
    namespace = agent_meant(path, there, agent)
    swarm, _, name = namespace.rpartition("/")
    world = f"{swarm}/{names.WORLD}"
    seen_on = next(topic for topic in _PERCEPTS if (namespace, "/", topic) in parts)
    told = [f"{namespace}/{topic}" for topic in (seen_on, VELOCITY_TOPIC, names.STATUS)]
    told += [f"{world}/{names.ACTIONS}", f"{world}/{names.STATUS}"]
    seen: list[tuple[float, Any]] = []
    did: list[Any] = []
    latest: dict[int, int] = {}  # percepts by their numbers, which a restarted world gives again
    early: dict[int, Any] = {}
    velocity, domain = None, ""
    for message in messages:
        if message.topic not in told:
            continue
        content, topic = message.decoded(), message.topic.rpartition("/")[2]
        if topic == seen_on:
            if content.look or (seen and seen[-1][1].sequence == content.sequence):
                continue  # shown again, to a recorder or in a paused world
            latest[content.sequence] = len(seen)
            seen.append((message.received / NANOSECONDS, content))
            did.append(velocity or early.pop(content.sequence, None))
        elif topic == names.ACTIONS and content.agent == name:
            if velocity is not None:
                continue  # a robot did as the velocity says, from any driver
            if content.sequence in latest:
                did[latest[content.sequence]] = content.values
            else:
                early[content.sequence] = content.values
        elif topic == VELOCITY_TOPIC:
            twist = getattr(content, "twist", content)
            velocity = twist.linear.x, twist.linear.y, twist.angular.z
            if did:
                did[-1] = velocity
        elif message.topic == told[-1]:
            domain = domain or content.world  # who answers in its place has no status
        elif topic == names.STATUS:
            domain = content.domain
    if not seen:
        raise SwarmError(
            f"{path.name} has no cycle of {name}: the world was paused while it was recorded",
            Fix.RESUME_WORLD(),
            Fix.RECORD(),
        )
    if not any(action is not None for action in did):
        raise SwarmError(
            f"{path.name} has {quantity(len(seen), 'percept')} of {name}, but not what was done: "
            f"it lacks its actions on {world}/{names.ACTIONS}, or of a robot {told[1]}",
            Fix.RECORD(),
        )
    moments, episode = [], 0
    for (when, p), action in zip(seen, did, strict=True):
        episode += p.restart
        time, after = seconds_of(p.stamp), when - seen[0][0]
        moments.append(ShownAction(after, time, p.cycle, episode, p.values, p.heard, action))
    return Driven(name, domain, seen[0][0], moments, messages.missing)
