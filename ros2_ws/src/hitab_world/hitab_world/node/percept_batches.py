"""Messages with the percepts of many agents."""

from __future__ import annotations

import sys
from array import array
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from hitab_msgs import msg

Sensed = tuple[Sequence[float], Sequence[str]]
"""A percept: its values, and what the agent hears."""

AGENT_BYTES, VALUE_BYTES, TEXT_BYTES = 12, 8, 8
"""Sizes of an agent's index and counts, of a value, and of a text without its letters."""


def percept_batches(
    roster: int,
    common: dict[str, Any],
    sensed: Iterable[tuple[int, Sensed | None]],
    bytes_max: int = sys.maxsize,
) -> Iterator[msg.PerceptBatch]:
    """Yield messages with the percepts of some agents; at least one, which may be empty.

    Args:
        roster: number of the roster to which the indices refer.
        common: the fields that all percepts of a cycle share.
        sensed: index and percept of each agent; agents without a percept are left out.
        bytes_max: maximum size of a message; one with a single percept may be larger.
    """
    batch, size = _Batch(), 0
    for index, percept in sensed:
        if percept is None:
            continue
        seen, said = percept
        added = AGENT_BYTES + VALUE_BYTES * len(seen)
        if said:
            added += sum(TEXT_BYTES + 4 * len(text) for text in said)
        if size and size + added > bytes_max:
            yield batch.message(roster, common)
            batch, size = _Batch(), 0
        size += added
        batch.add(index, seen, said)
    yield batch.message(roster, common)


class _Batch:
    """The percepts of a message."""

    def __init__(self) -> None:
        self.agents, self.values, self.value_counts = array("I"), array("d"), array("I")
        self.heard_counts, self.heard = array("I"), list[str]()

    def add(self, index: int, seen: Sequence[float], said: Sequence[str]) -> None:
        self.agents.append(index)
        self.values.extend(seen)
        self.value_counts.append(len(seen))
        self.heard_counts.append(len(said))
        self.heard += said

    def message(self, roster: int, common: dict[str, Any]) -> msg.PerceptBatch:
        batch = msg.PerceptBatch(roster=roster, **common)
        batch.agents, batch.values = self.agents, self.values
        batch.value_counts = self.value_counts
        if self.heard:
            batch.heard, batch.heard_counts = self.heard, self.heard_counts
        return batch
