"""The trainer: a client of the server that can move the ball and players."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from hitab_rcssserver.connection import (
    NoAnswer,
    ServerError,
    connect,
    parsed,
    readable,
)
from hitab_rcssserver.messages import LEFT, RIGHT, Ok, Refusal
from hitab_rcssserver.server_settings import ServerSettings
from hitab_rcssserver.sighting import Who
from hitab_ros.timing import REPEAT_S
from keepaway_world.game.arranging import Place


class OfflineTrainer:
    """A trainer (offline coach) on a server that was started with ``server::coach_w_referee=1``.

    Args:
        server: address of the server and the names of the teams.

    Raises:
        ServerError: if the server does not accept a trainer.
    """

    def __init__(self, server: ServerSettings) -> None:
        self._connection = connect(server.host, server.trainer_port)
        self._teams = {LEFT: server.team, RIGHT: server.taker_team}
        self.close = self._connection.close

    def put(
        self, places: Mapping[str, Place], who: Mapping[str, Who], center: float, *before: str
    ) -> None:
        """Put the ball and players somewhere; wait until the server has moved them.

        Args:
            places: the new places by name, in HiTAB's terms.
            who: side and number of each player, by name.
            center: x coordinate of our field's center on the server's field, m.
            before: trainer's commands to send first.

        Raises:
            NoAnswer: if the server is gone.
            ServerError: if the server refuses.
        """
        self._connection.receive()
        self._connection.send(*before)
        for name, (x, y, heading, vx, vy) in places.items():
            thing, angle = "(ball)", 0.0
            if name != "ball":
                side, number = who[name]
                thing, angle = f"(player {self._teams[side]} {number})", -math.degrees(heading)
            self._connection.send(
                f"(move {thing} {x + center:.6f} {-y:.6f} {angle:.6f} {vx:.6f} {-vy:.6f})"
            )
        count, deadline = len(before) + len(places), time.monotonic() + REPEAT_S
        while count:
            left = deadline - time.monotonic()
            if left <= 0.0:
                where = self._connection.where
                raise NoAnswer(f"the trainer's commands got no answer from {where}")
            readable([self._connection], left)
            for message in map(parsed, self._connection.receive()):
                count -= isinstance(message, Ok)
                if isinstance(message, Refusal):
                    raise ServerError(f"the server refuses to move something: {message.reason}")
