"""Which rcssserver is played on, and what this world is on it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from hitab_world.parameters import ParameterError, Parameters, between, one_of
from keepaway_world.parameters import KeepawayParameters

FULL_STATE, SEE = "fullstate", "see"
PERCEPTS = (FULL_STATE, SEE)

_TEAM = re.compile(r"[-+_a-zA-Z0-9]{1,15}")


@dataclass(frozen=True)
class ServerSettings(Parameters):
    """Which server, and what we are on it.

    Attributes:
        host, port: where it takes players.
        trainer_port: where it takes a trainer, usually 6001; 0: connect none.
        team, taker_team: names of the teams.
        our_takers: whether the takers are played by this world; else they are someone else's
            clients, which connect after the keepers.
        kick_off: whether this world has the server begin to play once all players are there.
        percepts: what the keepers perceive by: "fullstate", the server's exact account, quantised
            as `KeepawayParameters.sight` says; or "see", what the server lets each of them see.
    """

    WORLD = "rcssserver"
    LIMITS = MappingProxyType(
        {
            "port": between(1, 65535),
            "trainer_port": between(0, 65535),
            "percepts": one_of(*PERCEPTS),
        }
    )

    host: str = "127.0.0.1"
    port: int = 6000
    trainer_port: int = 0
    team: str = "keepers"
    taker_team: str = "takers"
    our_takers: bool = True
    kick_off: bool = True
    percepts: str = FULL_STATE

    def __post_init__(self) -> None:
        """Refuse what cannot be an address, the name of a team or a kind of percept."""
        super().__post_init__()
        for name in ("team", "taker_team"):
            if not _TEAM.fullmatch(getattr(self, name)):
                raise ParameterError(
                    f'{name} is "{getattr(self, name)}"; a team has a name of 1 to 15 letters, '
                    "digits, _, + and -"
                )
        if self.team == self.taker_team:
            raise ParameterError(f'both teams are called "{self.team}"; give one another name')

    @property
    def where(self) -> str:
        """The server's address, as it is told to a user."""
        return f"{self.host}:{self.port}"


def settings_from_dict(values: Mapping[str, Any]) -> tuple[ServerSettings, KeepawayParameters]:
    """Return what such a world's parameters say of the server, and of the game.

    Raises:
        ValueError: if there is no such parameter, or a value cannot be.
    """
    names = {field.name for field in fields(ServerSettings)}
    server = {name: value for name, value in values.items() if name in names}
    game = {name: value for name, value in values.items() if name not in names}
    return ServerSettings(**server), KeepawayParameters.from_dict(game)
