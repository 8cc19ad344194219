"""Percepts and actions as bytes, in the encoding of DDS (CDR).

They are sent in each cycle, and `rclpy` takes ten times as long to convert them.
"""

from __future__ import annotations

import struct
import sys
from array import array
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

from builtin_interfaces.msg import Time
from hitab_msgs import msg
from rclpy.serialization import deserialize_message

from hitab_ros.messages.checks import BadMessage

NATIVE = b"\0\1\0\0" if sys.byteorder == "little" else b"\0\0\0\0"
"""Header of the plain encoding in this machine's byte order; `rclpy` reads any other."""

_PERCEPT = struct.Struct("=4siI4Q4?I")  # up to the number of values
_ACTION = struct.Struct("=QI")
_COUNT = struct.Struct("=I")
_FLAG = struct.Struct("=?")


def percept_bytes(
    stamp: Time,
    sequence: int,
    cycle: int,
    episode: int,
    seed: int,
    *,
    look: bool,
    lockstep: bool,
    restart: bool,
    back: bool,
    values: Sequence[float],
    heard: Sequence[str],
) -> bytes:
    """Return a `msg.Percept` with these fields as bytes."""
    now, run = (stamp.sec, stamp.nanosec), (sequence, cycle, episode, seed)
    begin = _PERCEPT.pack(NATIVE, *now, *run, look, lockstep, restart, back, len(values))
    data = begin + array("d", values).tobytes() + _COUNT.pack(len(heard))
    for text in heard:
        data += _padding(data, 4) + _text(text)
    return data


def read_percept(data: bytes) -> Any:
    """Return the fields of a `msg.Percept`.

    Raises:
        BadMessage: if the bytes are no percept.
    """
    if data[:4] != NATIVE:
        return deserialize_message(data, msg.Percept)
    try:
        _, sec, nanosec, *fields, count = _PERCEPT.unpack_from(data)
        sequence, cycle, episode, seed, look, lockstep, restart, back = fields
        values, end = _values(data, _PERCEPT.size, count)
        heard = []
        (texts,) = _COUNT.unpack_from(data, end)
        end += 4
        for _ in range(texts):
            text, end = _read_text(data, end)
            heard.append(text)
    except (struct.error, ValueError) as error:
        raise BadMessage(f"it is no percept: {error}") from None
    return SimpleNamespace(
        stamp=Time(sec=sec, nanosec=nanosec),
        sequence=sequence,
        cycle=cycle,
        episode=episode,
        seed=seed,
        look=look,
        lockstep=lockstep,
        restart=restart,
        back=back,
        values=values,
        heard=heard,
    )


def action_bytes(
    agent: str, sequence: int, values: Sequence[float], say: str, taught: bool, hold: str
) -> bytes:
    """Return a `msg.Action` with these fields as bytes."""
    data = NATIVE + _text(agent)
    data += _padding(data, 8) + _ACTION.pack(sequence, len(values))
    if values:
        data += _padding(data, 8) + array("d", values).tobytes()
    data += _text(say) + _FLAG.pack(taught)
    return data + _padding(data, 4) + _text(hold)


def read_action(data: bytes) -> Any:
    """Return the fields of a `msg.Action`.

    Raises:
        BadMessage: if the bytes are no action.
    """
    if data[:4] != NATIVE:
        return deserialize_message(data, msg.Action)
    try:
        agent, end = _read_text(data, 4)
        end += -(end - 4) % 8
        sequence, count = _ACTION.unpack_from(data, end)
        end += _ACTION.size
        values, end = _values(data, end + 4 if count else end, count)
        say, end = _read_text(data, end)
        (taught,) = _FLAG.unpack_from(data, end)
        hold, _ = _read_text(data, end + 1)
    except (struct.error, ValueError) as error:
        raise BadMessage(f"it is no action: {error}") from None
    return SimpleNamespace(
        agent=agent, sequence=sequence, values=values, say=say, taught=taught, hold=hold
    )


def _padding(data: bytes, size: int) -> bytes:
    """Return the bytes before a number of a size: places count from the end of the header."""
    return bytes(-(len(data) - len(NATIVE)) % size)


def _text(text: str) -> bytes:
    encoded = text.encode()
    return _COUNT.pack(len(encoded) + 1) + encoded + b"\0"


def _read_text(data: bytes, begin: int) -> tuple[str, int]:
    begin += -begin % 4
    (size,) = _COUNT.unpack_from(data, begin)
    begin, end = begin + 4, begin + 4 + size
    if end > len(data):
        raise ValueError("a text is cut off")
    return data[begin : end - 1 if size else end].decode(), end


def _values(data: bytes, begin: int, count: int) -> tuple[array[float], int]:
    end = begin + 8 * count
    if end > len(data):
        raise ValueError("its values are cut off")
    return array("d", data[begin:end]), end
