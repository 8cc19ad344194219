"""Reads recordings: those of this package, and bags of ``ros2 bag record`` in MCAP."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from hitab_msgs.msg import Distribution
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Schema
from rclpy.serialization import deserialize_message

from hitab_client.errors import SwarmError
from hitab_client.recording.bag_file import FORMAT, METADATA
from hitab_client.recording.definitions import definition, message_class, type_name
from hitab_core import Do, has, newer_format
from hitab_ros import names, own_hash, session_topics

MAGIC = b"\x89MCAP0\r\n"


@dataclass(frozen=True, slots=True)
class Received:
    """A recorded message.

    Attributes:
        file: name of the recording.
        topic: its full name.
        schema: of its type.
        type_hash: of the definition, as ROS 2 announced it; empty: unknown.
        sent, received: ns since 1970.
        data: serialized.
    """

    file: str
    topic: str
    schema: Schema
    type_hash: str
    sent: int
    received: int
    data: bytes

    def decoded(self) -> Any:
        """Return the message.

        Raises:
            SwarmError: if its type is defined differently here.
        """
        name = self.schema.name
        kind = message_class(name)
        if self.type_hash:
            is_ours = self.type_hash == own_hash(name)
        else:
            is_ours = self.schema.data == definition(name).encode()
        if not is_ours:
            raise SwarmError(
                f"{self.file} has messages of type {name} on {self.topic}, which is defined "
                "differently here; use the version of HiTAB that recorded it"
            )
        return deserialize_message(self.data, kind)


@contextmanager
def opened(path: Path) -> Iterator[Iterator[Received]]:
    """Open a recording; the context's value yields its messages in the order of their reception.

    Args:
        path: of the file.

    Raises:
        SwarmError: if it is no recording, not complete, or of a newer format.
    """
    try:
        with path.open("rb") as stream:
            _check_whole(path.name, stream)
            reader = make_reader(stream)
            for metadata in reader.iter_metadata():
                found = metadata.metadata.get("format", "1") if metadata.name == METADATA else "1"
                if not found.isdecimal() or int(found) > FORMAT:
                    raise SwarmError(f"{path.name} {newer_format(found, FORMAT)}")
            yield _messages(path.name, reader)
    except (OSError, McapError, ValueError) as error:
        raise SwarmError(f"{path.name} cannot be read: {error}") from None


def _messages(file: str, reader: Any) -> Iterator[Received]:
    for schema, channel, message in reader.iter_messages():
        if schema is not None:
            yield Received(
                file,
                channel.topic,
                schema,
                channel.metadata.get("topic_type_hash", ""),
                message.publish_time,
                message.log_time,
                message.data,
            )


def _check_whole(name: str, stream: BinaryIO) -> None:
    """Raise if a file does not begin and end as MCAP."""
    begins = stream.read(len(MAGIC))
    size = stream.seek(0, io.SEEK_END)
    stream.seek(max(len(MAGIC), size - len(MAGIC)))
    if begins != MAGIC or stream.read() != MAGIC:
        raise SwarmError(
            f"{name} is no complete MCAP recording: whatever wrote it was killed or is still "
            "writing, or it is another bag, which `ros2 bag convert` converts"
        )
    stream.seek(0)


Sent = tuple[int, str, Any]
"""A message of an agent: when it was sent, ns; the last part of its topic; the message."""


@dataclass(frozen=True)
class Session:
    """What a recording has of one agent, from when it began to tell what it took in.

    Attributes:
        agent: its name.
        domain: the name of its domain.
        known: what it knew at the beginning.
        sent: its messages, in the order in which it sent them.
    """

    agent: str
    domain: str
    known: Distribution
    sent: list[Sent]


def trained_agents(path: Path) -> list[str]:
    """Return the agents, with their namespaces, whose sessions a recording has.

    Raises:
        SwarmError: if it cannot be read.
    """
    ending = f"/{session_topics.KNOWN}"
    kind = type_name(Distribution)
    with opened(path) as messages:
        topics = {m.topic for m in messages if m.schema.name == kind}
    return sorted(t.removesuffix(ending) for t in topics if t.endswith(ending))


def session_of(path: Path, agent: str) -> Session:
    """Return what a recording has of one agent.

    Args:
        path: of the recording.
        agent: its name, with its namespace if there are several of that name; empty: the only
            one that the recording has.

    Raises:
        SwarmError: if it has nothing of it, or messages are defined differently here.
    """
    namespace = _namespace(path, agent)
    told = (*session_topics.TOPICS, names.STATUS, names.TRANSITIONS)
    wanted = {f"{namespace}/{name}": name for name in told}
    sent: list[Sent] = []
    with opened(path) as messages:
        for message in messages:
            if name := wanted.get(message.topic):
                sent.append((message.sent, name, message.decoded()))
    sent.sort(key=lambda one: one[0])
    begun = next((s for s, name, _ in sent if name == session_topics.KNOWN), 0)
    known = next(m for _, name, m in sent if name == session_topics.KNOWN)
    domain = next((m.domain for _, name, m in sent if name == names.STATUS), "")
    if not domain:
        raise SwarmError(
            f"{path.name} lacks the topic {namespace}/{names.STATUS}, which names the agent's "
            "domain",
            Do.RECORD(),
        )
    return Session(
        namespace.rpartition("/")[2], domain, known, [one for one in sent if one[0] >= begun]
    )


def _namespace(path: Path, agent: str) -> str:
    """Return the namespace of an agent in a recording; of the only one, if none is named."""
    there = trained_agents(path)
    if not there:
        raise SwarmError(
            f"no agent can be trained from {path.name}: it lacks the topic "
            f"AGENT/{session_topics.KNOWN}, with which a session begins; agents with a process of "
            "their own have it",
            Do.RECORD(),
        )
    return agent_meant(path, there, agent)


def agent_meant(path: Path, there: Sequence[str], agent: str) -> str:
    """Return which of the agents in a recording is meant, with its namespace.

    Args:
        path: of the recording.
        there: the agents, with their namespaces.
        agent: its name, with its namespace if there are several of that name; empty: the only one.

    Raises:
        SwarmError: if it is not there, or there are several.
    """
    found = [n for n in there if agent in ("", n, n.removeprefix("/"), n.rpartition("/")[2])]
    if len(found) == 1:
        return found[0]
    what = "has several agents" if found else f'has nothing of an agent "{agent}"'
    raise SwarmError(f"{path.name} {what}; choose one with --agent {has(found or there, agent)}")
