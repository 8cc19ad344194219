"""Reads recordings: those of this package, and bags of ``ros2 bag record`` in MCAP."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Schema
from rclpy.serialization import deserialize_message

from hitab_client.errors import SwarmError
from hitab_client.recording.bag_file import FORMAT, METADATA
from hitab_client.recording.definitions import definition, message_class
from hitab_core import has, newer_format
from hitab_ros import own_hash

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
