"""Actions of an agent in a recording, cycle by cycle, without commands."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hitab_client.errors import SwarmError
from hitab_client.recording.reading import RecordedMessages, agent_meant
from hitab_core import Fix, quantity
from hitab_core.labeling import ShownAction
from hitab_ros import names
from hitab_ros.messages.stamps import seconds_of

VELOCITY_TOPIC = "cmd_vel"
"""Topic of a robot's applied velocity, in the agent's namespace."""

_PERCEPTS = (names.PERCEIVED, names.PERCEPT)


@dataclass(frozen=True)
class Driven:
    """Recorded actions of one agent.

    Attributes:
        agent: the agent's name.
        domain: name of the agent's domain.
        start: time of the first percept, s since 1970.
        moments: the cycles, with their times after the start, s.
        missing: what an unfinished recording lacks; empty if nothing.
    """

    agent: str
    domain: str
    start: float
    moments: list[ShownAction]
    missing: str


def driving_of(path: Path, agent: str = "") -> Driven:
    """Return the recorded actions of an agent, whatever program or person drove it.

    In a world, an agent or a program in its place publishes actions. A robot's actions are the
    velocities that its relay passed on, which include a person's driving by hand.

    Args:
        path: path of the recording.
        agent: the agent's name, with its namespace if the name is ambiguous; empty for the only
            agent.

    Raises:
        SwarmError: if the recording lacks percepts or actions of the agent.
    """
    messages = RecordedMessages(path)
    parts = {message.topic.rpartition("/") for message in messages}
    agents = sorted({namespace for namespace, _, name in parts if name in _PERCEPTS})
    if not agents:
        raise SwarmError(f"{path.name} has no percepts of any agent", Fix.RECORD())
    namespace = agent_meant(path, agents, agent)
    swarm, _, name = namespace.rpartition("/")
    world = f"{swarm}/{names.WORLD}"
    seen_on = next(topic for topic in _PERCEPTS if (namespace, "/", topic) in parts)
    topics = [f"{namespace}/{topic}" for topic in (seen_on, VELOCITY_TOPIC, names.STATUS)]
    topics += [f"{world}/{names.ACTIONS}", f"{world}/{names.STATUS}"]
    seen: list[tuple[float, Any]] = []
    did: list[Any] = []
    latest: dict[int, int] = {}  # percepts by number; a restarted world repeats numbers
    early: dict[int, Any] = {}
    velocity, domain = None, ""
    for message in messages:
        if message.topic not in topics:
            continue
        content, topic = message.decoded(), message.topic.rpartition("/")[2]
        if topic == seen_on:
            if content.look or (seen and seen[-1][1].sequence == content.sequence):
                continue  # repeated for a recorder, or in a paused world
            latest[content.sequence] = len(seen)
            seen.append((message.received / 1e9, content))
            did.append(velocity or early.pop(content.sequence, None))
        elif topic == names.ACTIONS and content.agent == name:
            if velocity is not None:
                continue  # a robot's action is its velocity, from any driver
            if content.sequence in latest:
                did[latest[content.sequence]] = content.values
            else:
                early[content.sequence] = content.values
        elif topic == VELOCITY_TOPIC:
            twist = getattr(content, "twist", content)
            velocity = twist.linear.x, twist.linear.y, twist.angular.z
            if did:
                did[-1] = velocity
        elif message.topic == topics[-1]:
            domain = domain or content.world  # a program in the agent's place publishes no status
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
            f"it lacks its actions on {world}/{names.ACTIONS}, or of a robot {topics[1]}",
            Fix.RECORD(),
        )
    moments, episode = [], 0
    for (when, p), action in zip(seen, did, strict=True):
        episode += p.restart
        time, after = seconds_of(p.stamp), when - seen[0][0]
        moments.append(ShownAction(after, time, p.cycle, episode, p.values, p.heard, action))
    return Driven(name, domain, seen[0][0], moments, messages.missing)
