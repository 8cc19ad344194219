"""The field as last reported by the server, in HiTAB's terms: y up, radians, our names.

The field is stored in the bodies of the simulated world, for percepts, takers and referee; the
physics never moves these bodies here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from operator import attrgetter
from random import Random
from typing import Any

from hitab_rcssserver.connection import ServerError
from hitab_rcssserver.messages import LEFT, RIGHT, FullState, Settings
from hitab_world.parameters import ParameterError
from keepaway_world.game.arranging import Place
from keepaway_world.game.physics import Mover, Physics
from keepaway_world.game.rules import Rules
from keepaway_world.parameters import KeepawayParameters

BOX: Mapping[str, str] = {"width": "keepaway_length", "height": "keepaway_width"}
SETTINGS: Mapping[str, str] = {
    "player_radius": "player_size",
    "ball_radius": "ball_size",
    "player_acceleration_max": "player_accel_max",
    "ball_acceleration_max": "ball_accel_max",
    "dash_rate": "dash_power_rate",
    "kick_rate": "kick_power_rate",
    "inertia": "inertia_moment",
    "say_range": "audio_cut_dist",
    "say_length": "say_msg_size",
    **dict.fromkeys(("kickable_margin", "player_decay", "ball_decay"), ""),
    **dict.fromkeys(("player_speed_max", "ball_speed_max"), ""),
    **dict.fromkeys(("player_rand", "ball_rand", "kick_rand"), ""),
}
"""Parameters that the server decides, with the server's names; "" for the same name. A server that
plays keepaway itself also decides `BOX`."""


def parameters_of(server: Settings, ours: KeepawayParameters, rules: Rules) -> KeepawayParameters:
    """Return the parameters of the server's game.

    Raises:
        ServerError: if it plays an unknown game.
    """
    decided = SETTINGS if rules.stops else {**BOX, **SETTINGS}
    figures: dict[str, Any] = {
        name: type(mine)(server.number(theirs or name, mine))
        for name, theirs in decided.items()
        for mine in [getattr(ours, name)]
    }
    try:
        return replace(ours, **figures)
    except ParameterError as error:
        raise ServerError(f"the server's settings do not fit {rules.name}: {error}") from None


class ReportedField:
    """Everything on the field.

    Args:
        parameters, rules: parameters and rules of the game.

    Attributes:
        physics: the bodies at their last positions.
        who: side and number of each player that the server has reported, by name.
    """

    def __init__(self, parameters: KeepawayParameters, rules: Rules) -> None:
        self.physics = Physics(parameters, Random(), rules.names)
        self.who: dict[str, tuple[str, int]] = {}
        self._center = rules.center
        self.movers: dict[str, Mover] = {mover.name: mover for mover in self.physics.movers}
        self._teams = (LEFT, self.physics.keepers), (RIGHT, self.physics.takers)

    def take(self, state: FullState) -> list[Mover]:
        """Adopt the server's state; return the players that kick in this cycle.

        The keepers are the left team and the takers the right one, each by rising number, a
        goalie last.
        """
        ball = self.physics.ball
        reach = self.physics.parameters.kickable * 1.05
        could_kick = [
            player
            for player in self.physics.players
            if math.hypot(player.x - ball.x, player.y - ball.y) <= reach
        ]
        x, y, vx, vy = state.ball
        self.physics.put(ball, x - self._center, -y, 0.0, vx, -vy)
        kicked = []
        for side, movers in self._teams:
            team = [player for player in state.players if player.side == side]
            team.sort(key=attrgetter("goalie", "number"))
            for mover, player in zip(movers, team, strict=False):
                self.who[mover.name] = side, player.number
                heading = math.remainder(-math.radians(player.body), 2.0 * math.pi)
                x = player.x - self._center
                self.physics.put(mover, x, -player.y, heading, player.vx, -player.vy)
                if player.kicked and mover in could_kick:
                    kicked.append(mover)
        return kicked

    def missing(self, state: FullState) -> str:
        """Return a sentence about missing or extra players; "" if all are there."""
        for (side, movers), team in zip(self._teams, ("keepers", "takers"), strict=True):
            there = sum(player.side == side for player in state.players)
            if there != len(movers):
                return (
                    f"the server has {there} {team} but this world {len(movers)}; connect all "
                    f"players before play starts, or set the parameter {team} to {there}"
                )
        return ""

    def put(self, places: Mapping[str, Place]) -> None:
        """Put things somewhere; the caller must also inform the server."""
        for name, place in places.items():
            self.physics.put(self.movers[name], *place)
