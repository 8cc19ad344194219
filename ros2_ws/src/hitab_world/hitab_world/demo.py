"""A demo, as data for `hitab demo`; a domain offers one by entry point."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

DEMO_ENTRY_POINTS = "hitab.demos"
"""The entry-point group; a demo has the name of its domain."""


@dataclass(frozen=True)
class Demo:
    """A demo of training, as data.

    Attributes:
        swarm: a shipped swarm with a world, in which one agent is taught.
        lessons: shipped lessons, in the order in which they are played.
        behavior: performed by all agents afterwards.
        against: the opponents, for the title of the result.
        reference: source of ``references`` and ``examples``, such as ``paper``.
        references: mean and standard error (None if unknown) of the measures in the source.
        examples: number of examples for each automaton in the source.
        closing: a sentence about the effort of training in the source.
    """

    swarm: str
    lessons: tuple[str, ...]
    behavior: str
    against: str = ""
    reference: str = "reference"
    references: Mapping[str, tuple[float, float | None]] = field(default_factory=dict)
    examples: Mapping[str, int] = field(default_factory=dict)
    closing: str = ""
