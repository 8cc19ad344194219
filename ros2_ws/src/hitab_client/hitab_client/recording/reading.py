"""Reader of recordings, including MCAP bags of ``ros2 bag record``.

A file is read from the beginning to the end of its data, in the order of writing. The index, which
an unfinished file lacks, and the times, whose clock may have been set, do not give that order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any, BinaryIO

from mcap.reader import make_reader
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk, get_chunk_data_stream
from rclpy.serialization import deserialize_message

from hitab_client.errors import SwarmError
from hitab_client.recording.bag_file import BAG_FORMAT, METADATA
from hitab_client.recording.message_definitions import message_class, same_definition
from hitab_client.recording.recordings import RECORDING_SUFFIX
from hitab_core import has, natural, newer_format, quantity
from hitab_ros import own_hash
from hitab_ros.messages.stamps import NANOSECONDS

MAGIC = b"\x89MCAP0\r\n"
ZSTD = b"\x28\xb5\x2f\xfd"
"""First bytes of a message that ``ros2 bag record --compression-mode message`` has compressed."""

OTHER = "; `ros2 bag convert` converts other bags, and `zstd -d` unpacks .zstd files"

SET_AHEAD_NS = 24 * 3600 * NANOSECONDS
"""A longer pause between two messages means that the clock was set, as a second back does."""


@dataclass(frozen=True, slots=True)
class Received:
    """A recorded message.

    Attributes:
        file: name of the recording.
        channel: channel of the message, with its topic.
        schema: schema of the message's type.
        received: time of receipt, ns, by a clock that starts at the recorded time and is never
            set.
        data: serialized message.
    """

    file: str
    channel: Channel
    schema: Schema
    received: int
    data: bytes

    @property
    def topic(self) -> str:
        """Full name of the message's topic."""
        return self.channel.topic

    def decoded(self) -> Any:
        """Return the message.

        Raises:
            SwarmError: if the type is defined differently here, or decoding fails.
        """
        name = self.schema.name
        kind = message_class(name)
        announced = self.channel.metadata.get("topic_type_hash", "")
        if announced != own_hash(name) and (announced or not same_definition(self.schema)):
            raise SwarmError(
                f"{self.file} has messages of type {name} on {self.topic}, which is defined "
                "differently here; use the version of HiTAB that recorded it"
            )
        try:
            return deserialize_message(_unpacked(self.data), kind)
        except Exception:  # of rmw or zstandard; each has its own kind
            raise SwarmError(
                f"{self.file} has a message of type {name} on {self.topic} that cannot be decoded "
                f'(message encoding "{self.channel.message_encoding}"); only CDR is read, plain '
                "or compressed with zstd"
            ) from None


class RecordedMessages:
    """Messages of a recording in the order of writing; can be iterated repeatedly.

    Attributes:
        missing: what an unfinished file lacks, known after the last message; empty if nothing.
    """

    def __init__(self, path: Path) -> None:
        """Find the files of a recording.

        Args:
            path: a file, or the folder of a bag, which may have several files.

        Raises:
            SwarmError: if the folder has no file.
        """
        self.missing = ""
        self._files = [path]
        self._shift = self._last = 0
        if path.is_dir():
            self._files = sorted(
                path.glob(f"*{RECORDING_SUFFIX}"), key=lambda file: natural(file.name)
            )
            if not self._files:
                raise SwarmError(f"{path} is a folder without an MCAP file{OTHER}")

    def __iter__(self) -> Iterator[Received]:
        """Yield each message.

        Raises:
            SwarmError: if the file is no recording, damaged, or of a newer format.
        """
        self.missing = ""
        self._shift = self._last = 0
        for file in self._files:
            yield from self._read(file)

    def _read(self, path: Path) -> Iterator[Received]:
        schemas: dict[int, Schema] = {}
        channels: dict[int, Channel] = {}
        at = count = size = messages = 0
        is_finished = True
        try:
            with path.open("rb") as stream:
                is_finished, size = _looked_at(path, stream)
                for records in _records(stream, size):
                    for inner in records:
                        if isinstance(inner, Schema):
                            schemas[inner.id] = inner
                        elif isinstance(inner, Channel):
                            channels[inner.id] = inner
                        elif isinstance(inner, Metadata):
                            _check_format(path, inner)
                        elif isinstance(inner, Message):
                            messages += 1
                            channel = channels[inner.channel_id]
                            if channel.schema_id:
                                count += 1
                                schema = schemas[channel.schema_id]
                                when = self._time(inner.log_time)
                                yield Received(path.name, channel, schema, when, inner.data)
                    at = stream.tell()
                if is_finished and messages < (all_of_it := _message_count(stream)):
                    # A chunk with a wrong byte in its type looks like a record to be skipped.
                    raise SwarmError(
                        f"{path} is damaged: {messages} of its {all_of_it} messages can be found; "
                        "copy it again from where it was recorded"
                    )
        except SwarmError:
            raise
        except OSError as error:
            raise SwarmError(f"{path} cannot be read: {error.strerror}") from None
        except Exception:  # wrong bytes make all kinds of errors in mcap, struct, zstd and lz4
            if is_finished:
                part = f"part{RECORDING_SUFFIX}"
                before = f", or read what is before: `head -c {at} {quote(str(path))} > {part}`"
                raise SwarmError(
                    f"{path} is damaged after byte {at} of {size}; copy it again from where it "
                    f"was recorded{before if count else ''}"
                ) from None
            self.missing = (
                f"{path.name} is not finished: {quantity(count, 'message')} were read, up to byte "
                f"{at} of {size}. Its recorder was killed, had no space, or is still recording"
            )
            if not count:
                raise SwarmError(self.missing) from None

    def _time(self, logged: int) -> int:
        """Return the log time of a message, without the jumps of a clock that was set."""
        if not self._last:
            self._last = logged
        ahead = logged + self._shift - self._last
        if not -NANOSECONDS <= ahead <= SET_AHEAD_NS:
            self._shift -= ahead
            ahead = 0
        self._last += max(0, ahead)
        return self._last


def _looked_at(path: Path, stream: BinaryIO) -> tuple[bool, int]:
    """Return whether a file ends as a finished MCAP file, and its size.

    Raises:
        SwarmError: if the file does not begin as an MCAP file.
    """
    begins = stream.read(len(MAGIC))
    size = stream.seek(0, 2)
    stream.seek(max(0, size - len(MAGIC)))
    ends = stream.read()
    stream.seek(0)
    if begins != MAGIC[: len(begins)] or not begins:
        raise SwarmError(f"{path} is no MCAP recording{OTHER}")
    return size > len(MAGIC) and ends == MAGIC, size


def _records(stream: BinaryIO, size: int) -> Iterator[list[McapRecord]]:
    """Yield the records of the data section, grouped by chunk."""
    reader = StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=size)
    for record in reader.records:
        if isinstance(record, DataEnd):
            return  # the summary only repeats the data
        if isinstance(record, Chunk):
            yield breakup_chunk(record, validate_crc=True)
        else:
            yield [record]


def _message_count(stream: BinaryIO) -> int:
    """Return the number of messages in a finished file's summary; 0 if unknown."""
    stream.seek(0)
    try:
        summary = make_reader(stream).get_summary()
        return summary.statistics.message_count if summary and summary.statistics else 0
    except Exception:  # a damaged summary loses no messages
        return 0


def _unpacked(data: bytes) -> bytes:
    """Return a message, decompressed if necessary; CDR has another beginning."""
    if not data.startswith(ZSTD):
        return data
    stream, size = get_chunk_data_stream(Chunk("zstd", data, 0, 0, 0, 0))
    return stream.read(size)


def _check_format(path: Path, metadata: Metadata) -> None:
    found = metadata.metadata.get("format", "1") if metadata.name == METADATA else "1"
    if not found.isdecimal() or int(found) > BAG_FORMAT:
        raise SwarmError(f"{path.name} {newer_format(found, BAG_FORMAT)}")


def agent_meant(path: Path, agents: Sequence[str], agent: str) -> str:
    """Return the chosen agent of a recording, with its namespace.

    Args:
        path: path of the recording.
        agents: the recorded agents, with their namespaces.
        agent: the agent's name, with its namespace if the name is ambiguous; empty for the only
            agent.

    Raises:
        SwarmError: if no agent or several agents match.
    """
    found = [n for n in agents if agent in ("", n, n.removeprefix("/"), n.rpartition("/")[2])]
    if len(found) == 1:
        return found[0]
    what = "has several agents" if found else f'has nothing of an agent "{agent}"'
    raise SwarmError(f"{path.name} {what}; choose one with --agent {has(found or agents, agent)}")
