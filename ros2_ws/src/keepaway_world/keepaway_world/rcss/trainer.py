"""The trainer's connection, which can move things."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping

from keepaway_world.rcss.connection import Connection, NoAnswer, ServerError, connect, readable
from keepaway_world.rcss.field import Place
from keepaway_world.rcss.messages import Ok, Refusal
from keepaway_world.rcss.server_settings import ServerSettings

ANSWER_SECONDS = 0.5


class Trainer:
    """A trainer (offline coach) on a server that was started with ``server::coach_w_referee=1``.

    Args:
        server: its address and the names of the teams.

    Raises:
        ServerError: if the server does not accept it.
    """

    def __init__(self, server: ServerSettings) -> None:
        self._connection = connect(server.host, server.trainer_port)
        self._teams = {"keeper": server.team, "taker": server.taker_team}

    def put(self, places: Mapping[str, Place]) -> None:
        """Put the ball and players somewhere, by our names; wait until it is done.

        Raises:
            ServerError: if the server refuses; NoAnswer if it is gone.
        """
        self._connection.receive()
        for name, (x, y, heading, vx, vy) in places.items():
            angle = 0.0 if name == "ball" else -math.degrees(heading)
            self._connection.send(
                f"(move {self._object(name)} {x:.6f} {-y:.6f} {angle:.6f} {vx:.6f} {-vy:.6f})"
            )
        _await_oks(self._connection, len(places))

    def _object(self, name: str) -> str:
        if name == "ball":
            return "(ball)"
        kind, number = name.split("_")
        return f"(player {self._teams[kind]} {number})"

    def close(self) -> None:
        """Leave the server."""
        self._connection.close()


def _await_oks(connection: Connection, count: int) -> None:
    deadline = time.monotonic() + ANSWER_SECONDS
    while count:
        left = deadline - time.monotonic()
        if left <= 0.0:
            raise NoAnswer(f"the trainer's commands got no answer from {connection.where}")
        readable([connection], left)
        for text in connection.receive():
            message = connection.parse(text)
            if isinstance(message, Ok) and message.command == "move":
                count -= 1
            elif isinstance(message, Refusal) and message.kind == "error":
                raise ServerError(f"the server refuses to move something: {message.reason}")
