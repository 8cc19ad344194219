"""The settings of an rcssserver: its address, and this world's role on it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType
from typing import Any

from hitab_world.parameters import ParameterError, Parameters, between, one_of
from keepaway_world.parameters import KeepawayParameters

FULL_STATE, SEE = "fullstate", "see"
PERCEPT_MODES = (FULL_STATE, SEE)

_TEAM = re.compile(r"[-+_a-zA-Z0-9]{1,15}")


@dataclass(frozen=True)
class ServerSettings(Parameters):
    """The server, and our role on it.

    Attributes:
        host, port: the server's address for players.
        trainer_port: for a trainer, usually 6001; 0 to connect none.
        team, taker_team: names of the teams.
        our_takers: whether this world plays the takers; otherwise they are other clients, which
            must connect after the keepers.
        kick_off: whether this world makes the server start to play once all players have joined.
        percepts: source of the keepers' percepts: "fullstate" for the server's exact state,
            quantised as `KeepawayParameters.sight` says; "see" for each keeper's own sight.
    """

    WORLD = "rcssserver"
    LIMITS = MappingProxyType(
        {
            "port": between(1, 65535),
            "trainer_port": between(0, 65535),
            "percepts": one_of(*PERCEPT_MODES),
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
        """Refuse invalid addresses, team names and kinds of percepts."""
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
        """The server's address, for messages to a user."""
        return f"{self.host}:{self.port}"


def settings_from_dict(
    values: Mapping[str, Any], kind: type[KeepawayParameters] = KeepawayParameters
) -> tuple[ServerSettings, KeepawayParameters]:
    """Return the settings of the server and the parameters of the game.

    Raises:
        ValueError: if a parameter is unknown, or a value invalid.
    """
    names = {field.name for field in fields(ServerSettings)}
    server = {name: value for name, value in values.items() if name in names}
    game = {name: value for name, value in values.items() if name not in names}
    return ServerSettings(**server), kind.from_dict(game)
