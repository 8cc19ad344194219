"""Pieces of a cycle's percepts or actions, for machines whose network loses frames.

In real time, a message of the last cycle is worthless, so nothing is sent again when it is missed:
that takes longer than a cycle. Instead each piece fits into one frame, is useful by itself, and is
sent twice. A lost frame then costs nothing, and one of 400 pieces is lost if a network loses 5 %.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rclpy.serialization import deserialize_message, serialize_message

PIECE_BYTES = 1200
"""Maximum size of the contents of a piece; with its header, and those of DDS, UDP and IP, it fits
into an Ethernet frame, also in a tunnel."""

KEPT = 10_000
"""Number of latest pieces of which a second copy is recognized; more than a cycle has."""


def publish_pieces(publisher: Any, pieces: Iterable[Any]) -> None:
    """Publish each piece as it comes, then all again: losses often hit several frames in a row."""
    sent = []
    for piece in pieces:
        sent.append(serialize_message(piece))
        publisher.publish(sent[-1])
    for data in sent:
        publisher.publish(data)


class PieceReader:
    """Reads the first copy of each piece; for `GuardedNode.create_subscription`."""

    def __init__(self, kind: Any) -> None:
        self._kind = kind
        self._seen: dict[int, None] = {}  # hashes, since the bytes would take megabytes

    def __call__(self, data: bytes) -> Any:
        """Return the message; None for a copy of one that was read."""
        known = hash(data)
        if known in self._seen:
            return None
        self._seen[known] = None
        if len(self._seen) > KEPT:
            del self._seen[next(iter(self._seen))]
        return deserialize_message(data, self._kind)
