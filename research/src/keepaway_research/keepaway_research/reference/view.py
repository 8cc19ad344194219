"""A reference player's estimate of the field in one cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from keepaway_world.parameters import KeepawayParameters


@dataclass(slots=True)
class Seen:
    """The estimated state of the ball or a player; position in m, velocity in m/cycle."""

    name: str
    x: float
    y: float
    vx: float
    vy: float
    heading: float = 0.0

    def copy(self) -> Seen:
        """Return a copy."""
        return Seen(self.name, self.x, self.y, self.vx, self.vy, self.heading)


@dataclass(slots=True)
class View:
    """One player's estimate of the field in one cycle.

    Attributes:
        parameters: of the game, the same for all.
        me: the observer, one of the players.
        ball, keepers, takers: everything on the field.
    """

    parameters: KeepawayParameters
    me: Seen
    ball: Seen
    keepers: Sequence[Seen]
    takers: Sequence[Seen]

    @property
    def players(self) -> list[Seen]:
        """All players, including the observer."""
        return [*self.keepers, *self.takers]
