"""Connects many agents of one process to a world; what it needs of each of them."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Protocol

from hitab_msgs import msg

from hitab_core import Agent
from hitab_ros import Guard


class Perceiver(Protocol):
    """The part of an agent's node that perceives and acts."""

    agent_name: str
    agent: Agent
    guard: Guard

    def take_in(self, percept: msg.Percept) -> bool:
        """Perceive; return whether that succeeded.

        The percept object is reused: an agent must copy what it keeps.
        """

    def answer(self, percept: msg.Percept) -> tuple[Sequence[float], str]:
        """Act on the last percept, unless it is for inspection only."""

    def awaited_orders(self) -> Collection[str]:
        """Return the topics of the orders that it waits for in a lockstep round."""


class SharedLink(Protocol):
    """Passes percepts to many agents, and their actions to the world."""

    def add(self, perceiver: Perceiver) -> None:
        """Have an agent perceive and act from the next announcement on."""

    def announce(self) -> None:
        """Announce the agents to the world, and listen."""
