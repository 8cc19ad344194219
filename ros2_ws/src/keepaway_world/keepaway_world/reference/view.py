"""What a reference player takes the field to be in one cycle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from keepaway_world.parameters import KeepawayParameters


@dataclass(slots=True)
class Seen:
    """The ball or a player as it is taken to be; position in m, velocity in m/cycle."""

    name: str
    x: float
    y: float
    vx: float
    vy: float
    heading: float = 0.0


@dataclass(slots=True)
class View:
    """The field in one cycle, as one player takes it to be.

    Attributes:
        parameters: of the game, the same for all.
        me: who looks; one of the players.
        ball, keepers, takers: all that there is.
    """

    parameters: KeepawayParameters
    me: Seen
    ball: Seen
    keepers: Sequence[Seen]
    takers: Sequence[Seen]

    @property
    def players(self) -> list[Seen]:
        """All players, who looks included."""
        return [*self.keepers, *self.takers]
