"""The field as last reported by the server, in our own terms: y up, radians, our names.

It is stored in the bodies of the simulated world, which their physics never moves here, so that
percepts, takers and referee can read it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from random import Random
from typing import Any, TypeAlias

from hitab_core import has
from hitab_world import Entity, Placement, WorldError
from hitab_world.parameters import ParameterError
from keepaway_world.parameters import KeepawayParameters
from keepaway_world.percept import CYCLES_PER_SECOND
from keepaway_world.physics import Mover, Physics
from keepaway_world.rcss.connection import ServerError
from keepaway_world.rcss.messages import LEFT, RIGHT, FullState, Parameters

SETTINGS: Mapping[str, str] = {
    "width": "keepaway_length",
    "height": "keepaway_width",
    "player_radius": "player_size",
    "ball_radius": "ball_size",
    "kickable_margin": "kickable_margin",
    "player_decay": "player_decay",
    "ball_decay": "ball_decay",
    "player_acceleration_max": "player_accel_max",
    "ball_acceleration_max": "ball_accel_max",
    "player_speed_max": "player_speed_max",
    "ball_speed_max": "ball_speed_max",
    "player_rand": "player_rand",
    "ball_rand": "ball_rand",
    "kick_rand": "kick_rand",
    "dash_rate": "dash_power_rate",
    "kick_rate": "kick_power_rate",
    "inertia": "inertia_moment",
    "say_range": "audio_cut_dist",
}
"""Our parameters that the server decides, with its names for them."""


def parameters_of(server: Parameters, ours: KeepawayParameters) -> KeepawayParameters:
    """Return the parameters of the server's game.

    Raises:
        ServerError: if it plays an unknown game.
    """
    figures: dict[str, Any] = {
        name: server.number(setting, getattr(ours, name)) for name, setting in SETTINGS.items()
    }
    say_length = int(server.number("say_msg_size", ours.say_length))
    try:
        return replace(ours, **figures, say_length=say_length)
    except ParameterError as error:
        raise ServerError(f"the server's settings do not fit keepaway: {error}") from None


Place: TypeAlias = tuple[float, float, float, float, float]
"""x, y, heading, vx, vy: m, rad and m/cycle, y up."""


class Field:
    """Everything on the field.

    Args:
        parameters: of the game.

    Attributes:
        physics: the bodies at their last positions.
    """

    def __init__(self, parameters: KeepawayParameters) -> None:
        self.parameters = parameters
        self.physics = Physics(parameters, Random())
        self.movers: dict[str, Mover] = {mover.name: mover for mover in self.physics.movers}

    def take(self, state: FullState) -> list[str]:
        """Take over the server's state; return the names of the players that kick in this cycle.

        The keepers are the left team and the takers the right one, each by rising number.
        """
        physics = self.physics
        x, y, vx, vy = state.ball
        reach = physics.parameters.kickable * 1.05
        could_kick = {
            player.name
            for player in physics.players
            if math.hypot(player.x - physics.ball.x, player.y - physics.ball.y) <= reach
        }
        physics.put(physics.ball, x, -y, 0.0, vx, -vy)
        kicked = []
        for side, movers in ((LEFT, physics.keepers), (RIGHT, physics.takers)):
            team = sorted((p for p in state.players if p.side == side), key=lambda p: p.number)
            for mover, player in zip(movers, team, strict=False):
                heading = math.remainder(-math.radians(player.body), 2.0 * math.pi)
                physics.put(mover, player.x, -player.y, heading, player.vx, -player.vy)
                if player.kicked and mover.name in could_kick:
                    kicked.append(mover.name)
        return kicked

    def missing(self, state: FullState) -> str:
        """Return a sentence about missing or extra players, or ""."""
        p = self.parameters
        for side, team, wanted in ((LEFT, "keepers", p.keepers), (RIGHT, "takers", p.takers)):
            there = sum(player.side == side for player in state.players)
            if there != wanted:
                return (
                    f"the server has {there} {team} but this world {wanted}; connect all players "
                    f"before play starts, or set the parameter {team} to {there}"
                )
        return ""

    def entities(self, said: Mapping[str, str]) -> list[Entity]:
        """Return everything in SI units, for viewers."""
        return [
            Entity(
                mover.name,
                mover.kind,
                mover.x,
                mover.y,
                mover.heading,
                mover.vx * CYCLES_PER_SECOND,
                mover.vy * CYCLES_PER_SECOND,
                mover.radius,
                said.get(mover.name, ""),
            )
            for mover in self.physics.movers
        ]

    def places(self) -> dict[str, Place]:
        """Return all places: x, y, heading, vx, vy by name."""
        return {m.name: (m.x, m.y, m.heading, m.vx, m.vy) for m in self.physics.movers}

    def put(self, places: Mapping[str, Place]) -> None:
        """Put things somewhere; the caller must also inform the server."""
        for name, place in places.items():
            self.physics.put(self.movers[name], *place)


def placed(placements: Iterable[Placement], movers: Mapping[str, Mover]) -> dict[str, Place]:
    """Return the requested places, with NaN replaced by the current values.

    Raises:
        WorldError: naming what does not exist or is impossible.
    """
    places: dict[str, Place] = {}
    for p in placements:
        mover = movers.get(p.name)
        if mover is None:
            raise WorldError(f'nothing is called "{p.name}" {has(movers, p.name)}')
        given = (p.x, p.y, p.heading, p.vx / CYCLES_PER_SECOND, p.vy / CYCLES_PER_SECOND)
        now = (mover.x, mover.y, mover.heading, mover.vx, mover.vy)
        if any(math.isinf(value) for value in given):
            raise WorldError(f"{p.name}: a figure is infinite; give a number or NaN")
        x, y, heading, vx, vy = (
            old if math.isnan(new) else new for new, old in zip(given, now, strict=True)
        )
        if math.hypot(vx, vy) > mover.speed_max * 1.001:
            raise WorldError(
                f"{p.name}: a speed of {math.hypot(vx, vy) * CYCLES_PER_SECOND:.2f} m/s exceeds "
                f"its maximum, {mover.speed_max * CYCLES_PER_SECOND:g} m/s"
            )
        places[p.name] = x, y, math.remainder(heading, 2.0 * math.pi), vx, vy
    return places
