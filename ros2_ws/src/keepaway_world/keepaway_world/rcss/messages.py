"""rcssserver's messages to its clients, as data; protocol version 15.

All values are the server's own: y points down, angles are in degrees, clockwise, speeds are per
cycle. `keepaway_world.rcss.field` converts them to ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from keepaway_world.rcss.sexpr import Expression, ProtocolError, excerpt

LEFT, RIGHT = "l", "r"
REFEREE, SELF, OUR = "referee", "self", "our"
BEFORE_KICK_OFF, PLAYING = "before_kick_off", "play_on"
EPISODE_OVER = "training Keepaway 1"
"""The referee's message when an episode has ended and the next one has been set up."""


def number_of(atom: Expression) -> float:
    """Return an atom as a finite number.

    Raises:
        ProtocolError: if it is not one.
    """
    try:
        value = float(atom)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        raise ProtocolError(f"{excerpt(str(atom))} is not a number") from None
    if not math.isfinite(value):
        raise ProtocolError(f"{atom} is not finite")
    return value


@dataclass(frozen=True, slots=True)
class Init:
    """The answer to ``(init ...)``; ``side`` is "" and ``number`` 0 for a trainer."""

    side: str
    number: int
    mode: str


@dataclass(frozen=True, slots=True)
class Refusal:
    """An ``(error ...)`` or a ``(warning ...)``."""

    kind: str
    reason: str


@dataclass(frozen=True, slots=True)
class Parameters:
    """``server_param``, ``player_param`` or ``player_type``: settings by name."""

    kind: str
    values: Mapping[str, str]

    def number(self, name: str, otherwise: float) -> float:
        """Return a numeric setting, or ``otherwise`` if the server has none.

        Raises:
            ProtocolError: if it is not a number.
        """
        return number_of(self.values[name]) if name in self.values else otherwise


@dataclass(frozen=True, slots=True)
class SenseBody:
    """What a player feels: its speed and its direction, its neck, its kicks so far."""

    time: int
    speed: float
    speed_direction: float
    head_angle: float
    kicks: int


@dataclass(frozen=True, slots=True)
class PlayerState:
    """One player in a `FullState`; ``kicked``: it tried to kick in this cycle."""

    side: str
    number: int
    x: float
    y: float
    vx: float
    vy: float
    body: float
    kicked: bool = False


@dataclass(frozen=True, slots=True)
class FullState:
    """The true state of everything."""

    time: int
    mode: str
    ball: tuple[float, float, float, float]
    players: tuple[PlayerState, ...]


@dataclass(frozen=True, slots=True)
class SeenObject:
    """A seen object: its name in parts, such as ``("p", "takers", "2")``.

    Unknown values are NaN, such as the distance of a line of which only the end is seen.
    """

    name: tuple[str, ...]
    distance: float
    direction: float
    distance_change: float = math.nan
    direction_change: float = math.nan


@dataclass(frozen=True, slots=True)
class See:
    """What a player sees, relative to its neck."""

    time: int
    objects: tuple[SeenObject, ...]


@dataclass(frozen=True, slots=True)
class Hear:
    """Something said: by `REFEREE`, by `SELF`, or by a player of ``team`` "our" or "opp"."""

    time: int
    sender: str
    text: str
    team: str = ""
    number: int = 0


@dataclass(frozen=True, slots=True)
class Think:
    """In synch mode: the server waits for this client's commands and ``(done)``."""


@dataclass(frozen=True, slots=True)
class Ok:
    """A trainer's command was carried out."""

    command: str


@dataclass(frozen=True, slots=True)
class Other:
    """A message of another kind, which is not used here."""

    kind: str
    parts: Sequence[Expression] = field(default=(), repr=False)


Message: TypeAlias = (
    Init | Refusal | Parameters | SenseBody | FullState | See | Hear | Think | Ok | Other
)
