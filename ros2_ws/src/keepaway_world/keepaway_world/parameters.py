"""All settable figures of the keepaway world, and two named variants of the game.

Lengths are in m; speeds and accelerations are per cycle of 0.1 s, as in the RoboCup Soccer
Simulator (rcssserver 19) whose server parameters most of these are.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from types import MappingProxyType
from typing import Any

SIGHTS = ("quantised", "full")
RESET_ANGLES = ("drawn", "kept")
TAKER_POLICIES = ("intercept", "reference")


class ParameterError(ValueError):
    """A keepaway parameter that cannot be used; the message names it and what it may be."""


@dataclass(frozen=True)
class KeepawayParameters:
    """Figures of the game, the mechanics and the senses.

    Attributes:
        keepers, takers: number of players in each team.
        width, height: of the box, which is centred on the origin, m.
        taker_speed: factor on the power of the takers' dashes (the paper: a quarter), which they
            know of.
        taker_policy: "intercept": go where the ball can first be reached, seeing all exactly; or
            "reference": UT Austin's own takers, who see as `sight` says and do not know that
            they are slow. What these remember is not part of a snapshot.
        ball_collides: whether players collide with the ball (the paper: they cannot).
        players_collide: whether players collide with each other.
        sight: "quantised" as a player of rcssserver sees, or "full": exact.
        movement_noise, kick_noise, turn_noise: factors on the simulator's noise; 0 = none.
        reset_angles: where players look when an episode begins: "drawn" from the episode's own
            generator, so that an episode can be played by itself, or "kept" from the end of the
            one before, as rcssserver does.
        say_length: longest message, in characters.
        say_range: how far a message is heard, m.
        turnover_cycles: cycles of possession by takers after which the ball is taken.
        stuck_area, drop_ball_cycles: a ball that stays within so many m for so many cycles is
            dropped: it comes to rest and all players are moved away from it. No area, no drop.

    The rest are mechanics of rcssserver; `dash_rate`, `kick_rate` and `inertia` are its
    ``dash_power_rate``, ``kick_power_rate`` and ``inertia_moment``.
    """

    keepers: int = 3
    takers: int = 2
    width: float = 20.0
    height: float = 20.0
    taker_speed: float = 0.25
    taker_policy: str = "intercept"
    ball_collides: bool = False
    players_collide: bool = True
    sight: str = "quantised"
    movement_noise: float = 1.0
    kick_noise: float = 1.0
    turn_noise: float = 1.0
    reset_angles: str = "drawn"
    say_length: int = 10
    say_range: float = 50.0
    turnover_cycles: int = 4
    stuck_area: float = 3.0
    drop_ball_cycles: int = 100

    player_radius: float = 0.3
    ball_radius: float = 0.085
    kickable_margin: float = 0.7
    player_decay: float = 0.4
    ball_decay: float = 0.94
    player_acceleration_max: float = 1.0
    ball_acceleration_max: float = 2.7
    player_speed_max: float = 1.05
    ball_speed_max: float = 3.0
    player_rand: float = 0.1
    ball_rand: float = 0.05
    kick_rand: float = 0.1
    dash_rate: float = 0.006
    kick_rate: float = 0.027
    inertia: float = 5.0

    def __post_init__(self) -> None:
        """Refuse values that mean nothing."""
        for field in fields(self):
            value = getattr(self, field.name)
            if field.type == "bool":
                if not isinstance(value, bool):
                    raise ParameterError(f"{field.name} is {value!r}; it must be true or false")
            elif field.type == "int":
                least = 2 if field.name == "keepers" else 0 if field.name == "takers" else 1
                if not isinstance(value, int) or isinstance(value, bool) or value < least:
                    raise ParameterError(
                        f"{field.name} is {value!r}; it must be a whole number from {least} on"
                    )
            elif field.type == "float":
                self._check_figure(field.name, value)
        for name, allowed in (
            ("sight", SIGHTS),
            ("reset_angles", RESET_ANGLES),
            ("taker_policy", TAKER_POLICIES),
        ):
            if getattr(self, name) not in allowed:
                raise ParameterError(
                    f"{name} is {getattr(self, name)!r}; it must be one of: {', '.join(allowed)}"
                )

    def _check_figure(self, name: str, value: Any) -> None:
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"{name} is {value!r}; it must be a number")
        if not math.isfinite(value):
            raise ParameterError(f"{name} is {value}; it must be finite")
        if name in ("width", "height"):
            if value < 12.0:
                raise ParameterError(f"{name} is {value}; the box must be at least 12 m wide")
        elif name.endswith("_decay"):
            if not 0.0 < value < 1.0:
                raise ParameterError(f"{name} is {value}; it must lie between 0 and 1")
        elif value < 0.0:
            raise ParameterError(f"{name} is {value}; it must not be negative")
        elif value == 0.0 and name.endswith(("_radius", "_max", "_rate", "kickable_margin")):
            raise ParameterError(f"{name} is 0; it must be positive")

    @property
    def contact(self) -> float:
        """Distance between the centres of a player and the ball when they touch, m."""
        return self.player_radius + self.ball_radius

    @property
    def kickable(self) -> float:
        """Largest distance between the centres at which a player can kick the ball, m."""
        return self.contact + self.kickable_margin

    def as_dict(self) -> dict[str, Any]:
        """Return the values by name, as `from_dict` takes them."""
        return asdict(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> KeepawayParameters:
        """Return the parameters with these values, the rest as in the paper.

        Raises:
            ParameterError: if there is no such parameter, or the value cannot be used.
        """
        known = [field.name for field in fields(cls)]
        for name in values:
            if name not in known:
                raise ParameterError(
                    f'there is no keepaway parameter "{name}" (has: {", ".join(known)})'
                )
        return cls(**values)


PAPER = KeepawayParameters()
STANDARD = replace(PAPER, taker_speed=1.0, ball_collides=True, players_collide=True, sight="full")

VARIANTS: Mapping[str, KeepawayParameters] = MappingProxyType(
    {"paper": PAPER, "standard": STANDARD}
)
"""``paper``: section 6 of the paper. ``standard``: keepaway as in rcssserver, full speed."""


def variant(name: str, **changes: Any) -> KeepawayParameters:
    """Return a named variant with some values changed.

    Raises:
        ParameterError: if there is no such variant or parameter.
    """
    if name not in VARIANTS:
        raise ParameterError(
            f'there is no keepaway variant "{name}" (has: {", ".join(sorted(VARIANTS))})'
        )
    return KeepawayParameters.from_dict({**VARIANTS[name].as_dict(), **changes})
