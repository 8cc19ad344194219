"""All parameters of the keepaway world, and two named variants of the game.

Lengths are in m; speeds and accelerations are per cycle of 0.1 s, as in the RoboCup Soccer
Simulator (rcssserver 19); most of these are its server parameters.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

from hitab_core import unknown
from hitab_world.parameters import (
    FRACTION,
    NOT_NEGATIVE,
    ParameterError,
    Parameters,
    at_least,
    one_of,
)

SIGHTS = ("quantised", "full")
RESET_ANGLES = ("drawn", "kept")


_FROM_0 = (
    *("takers", "taker_speed", "movement_noise", "kick_noise", "turn_noise"),
    *("say_range", "stuck_area", "player_rand", "ball_rand", "kick_rand", "inertia"),
)


@dataclass(frozen=True)
class KeepawayParameters(Parameters):
    """Parameters of the game, the mechanics and the senses.

    Attributes:
        keepers, takers: number of players in each team.
        width, height: size of the box, which is centered on the origin, m.
        taker_speed: factor on the power of the takers' dashes (the paper: a quarter); the takers
            know it.
        taker_policy: "intercept": takers see everything exactly and go where they can first reach
            the ball. Other packages offer more policies, see `keepaway_world.game.players`; the
            memory of their takers is not part of a snapshot.
        ball_collides: whether players collide with the ball (the paper: they cannot).
        players_collide: whether players collide with each other.
        sight: "quantised" as a player of rcssserver sees, or "full": exact.
        movement_noise, kick_noise, turn_noise: factors on the simulator's noise; 0 = none.
        reset_angles: the players' headings when an episode begins: "drawn" from the episode's own
            generator, so that an episode can be played by itself, or "kept" from the end of the
            previous one, as in rcssserver.
        say_length: longest message, in characters.
        say_range: distance at which a message is heard, m.
        turnover_cycles: cycles of possession by takers after which the ball is taken.
        stuck_area, drop_ball_cycles: a ball that stays within this area, m, for this many cycles
            is dropped: it comes to rest and all players are moved away from it. An area of 0 turns
            this off.

    The rest are mechanics of rcssserver; `dash_rate`, `kick_rate` and `inertia` are its
    ``dash_power_rate``, ``kick_power_rate`` and ``inertia_moment``.
    """

    WORLD = "keepaway"
    LIMITS = MappingProxyType(
        {
            "keepers": at_least(2),
            **dict.fromkeys(("width", "height"), at_least(12.0, "m")),
            **dict.fromkeys(_FROM_0, NOT_NEGATIVE),
            **dict.fromkeys(("player_decay", "ball_decay"), FRACTION),
            "sight": one_of(*SIGHTS),
            "reset_angles": one_of(*RESET_ANGLES),
        }
    )

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

    @property
    def contact(self) -> float:
        """Distance between the centers of a player and the ball when they touch, m."""
        return self.player_radius + self.ball_radius

    @property
    def kickable(self) -> float:
        """Largest distance between the centers at which a player can kick the ball, m."""
        return self.contact + self.kickable_margin


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
        raise ParameterError(unknown("keepaway variant", name, VARIANTS))
    return KeepawayParameters.from_dict({**VARIANTS[name].as_dict(), **changes})
