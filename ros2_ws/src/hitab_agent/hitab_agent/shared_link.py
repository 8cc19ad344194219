"""What joins many agents of one process to a world, and what it needs of each of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol

from hitab_msgs import msg

from hitab_core import Agent
from hitab_ros import Guard


class Perceiver(Protocol):
    """An agent's node, as far as it perceives and acts."""

    agent_name: str
    agent: Agent
    guard: Guard

    def take_in(self, percept: msg.Percept) -> bool:
        """Perceive; return whether that went well.

        An agent takes values and messages out of the percept, which is used again.
        """

    def answer(self, percept: msg.Percept) -> tuple[Sequence[float], str]:
        """Act on what was perceived, unless the percept is only to be looked at."""

    def awaited_orders(self) -> Collection[str]:
        """Return the topics of the orders that it waits for in a round of lockstep."""


class SharedLink(Protocol):
    """Gives percepts to many agents, and their actions to the world."""

    def add(self, perceiver: Perceiver) -> None:
        """Have an agent perceive and act from the next announcement on."""

    def announce(self) -> None:
        """Announce to the world who is here, and listen."""
