"""One client of rcssserver: a UDP socket and the handshake that registers it."""

from __future__ import annotations

import contextlib
import select
import socket
import time
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar

from hitab_rcssserver.messages import (
    Init,
    Message,
    ProtocolError,
    Refusal,
    decode,
    parse_message,
)
from hitab_ros.timing import REPEAT_S
from hitab_world import WorldError

PROTOCOL_VERSION = 15

_DATAGRAM = 65_536

Readable = TypeVar("Readable", "ServerConnection", socket.socket)

WAY_OUT = (
    f"restart it: it must speak protocol version {PROTOCOL_VERSION}, has room for two teams, "
    "whose players cannot rejoin, and accepts a trainer with server::coach_w_referee=1 only"
)


class ServerError(WorldError):
    """A server that cannot be used; the text gives the reason and the way out in one sentence."""


class NoAnswer(ServerError):
    """A server that does not answer: it is not up yet, or no longer."""


class ServerConnection:
    """A client that the server has accepted.

    Attributes:
        where: the server's address, for messages to a user.
        init: the server's answer.
    """

    def __init__(self, sock: socket.socket, where: str, init: Init) -> None:
        self._socket = sock
        self.where = where
        self.init = init

    def fileno(self) -> int:
        """Return the socket's descriptor, for waiting on it."""
        return self._socket.fileno()

    def send(self, *commands: str) -> None:
        """Send commands, one datagram each, terminated by a NUL as the server requires.

        Raises:
            NoAnswer: if the server is gone.
        """
        try:
            for command in commands:
                self._socket.send(command.encode("ascii") + b"\0")
        except OSError as error:
            if not isinstance(error, BlockingIOError):  # a full buffer drops it, as UDP may
                raise self._gone() from error

    def receive(self) -> list[str]:
        """Return the datagrams that have arrived, without waiting, as text.

        Raises:
            NoAnswer: if the server is gone.
        """
        texts: list[str] = []
        while True:
            try:
                datagram = self._socket.recv(_DATAGRAM)
            except BlockingIOError:
                return texts
            except OSError as error:
                if texts:
                    return texts
                raise self._gone() from error
            with contextlib.suppress(ProtocolError):  # not from rcssserver
                texts.append(decode(datagram))

    def close(self) -> None:
        """Say goodbye, so that the server no longer waits for this client."""
        with contextlib.suppress(OSError):
            self._socket.send(b"(bye)\0")
        self._socket.close()

    def _gone(self) -> NoAnswer:
        return NoAnswer(f"the rcssserver at {self.where} has gone; start it again")


def parsed(text: str) -> Message | None:
    """Return the message in a datagram's text; None if this package has no use for it."""
    try:
        return parse_message(text)
    except ProtocolError:
        return None


def address_of(host: str, port: int) -> tuple[int, Any]:
    """Return the family and the address of a host and port.

    Raises:
        ServerError: if there is no such host.
    """
    try:
        family, *_, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    except (OSError, UnicodeError, OverflowError) as error:
        raise ServerError(f"{host}:{port} is not the address of a server: {error}") from None
    return family, address


def udp_socket(family: int) -> socket.socket:
    """Return a non-blocking datagram socket."""
    sock = socket.socket(family, socket.SOCK_DGRAM)
    sock.setblocking(False)
    return sock


def connect(
    host: str,
    port: int,
    team: str = "",
    *,
    goalie: bool = False,
    answer_seconds: float = REPEAT_S,
) -> ServerConnection:
    """Register a client with the server.

    Args:
        host: the server's host.
        port: the server's port: for players usually 6000, for the trainer usually 6001.
        team: name of the player's team; "" for a trainer.
        goalie: whether the player may catch the ball.
        answer_seconds: how long to wait for the answer.

    Raises:
        NoAnswer: if no answer comes.
        ServerError: if the server refuses, or is not an rcssserver.
    """
    where = f"{host}:{port}"
    family, address = address_of(host, port)
    sock = udp_socket(family)
    try:
        words = [*[team] * bool(team), f"(version {PROTOCOL_VERSION})", *["(goalie)"] * goalie]
        sock.sendto(f"(init {' '.join(words)})".encode("ascii") + b"\0", address)
        init, dedicated = _answer(sock, where, answer_seconds)
        sock.connect(dedicated)  # from now on the system reports when the server is gone
        return ServerConnection(sock, where, init)
    except OSError as error:
        sock.close()
        raise NoAnswer(f"no rcssserver can be reached at {where}: {error}") from None
    except BaseException:
        sock.close()
        raise


def _answer(sock: socket.socket, where: str, seconds: float) -> tuple[Init, tuple[object, ...]]:
    """Wait for the server's answer; return it and its source address."""
    deadline = time.monotonic() + seconds
    while (left := deadline - time.monotonic()) > 0:
        if not select.select([sock], [], [], left)[0]:
            break
        try:
            datagram, sender = sock.recvfrom(_DATAGRAM)
        except BlockingIOError:
            continue
        try:
            message = parse_message(decode(datagram))
        except ProtocolError as error:
            raise ServerError(f"the program at {where} is not an rcssserver: {error}") from None
        if isinstance(message, Init):
            return message, sender
        if isinstance(message, Refusal):
            reason = message.reason.replace("_", " ")
            raise ServerError(f'the rcssserver at {where} refuses ("{reason}"); {WAY_OUT}')
        # The answer itself was lost: later messages already come from the new port.
        with contextlib.suppress(OSError):
            sock.sendto(b"(bye)\0", sender)
        raise NoAnswer(f"the answer of the rcssserver at {where} was lost")
    raise NoAnswer(
        f"no rcssserver answers at {where}; start it, or correct the address (host and port)"
    )


def readable(connections: Iterable[Readable], seconds: float) -> Sequence[Readable]:
    """Wait until something has arrived; return the connections on which it has."""
    return select.select(list(connections), [], [], max(seconds, 0.0))[0]


def kick_off(host: str, port: int) -> None:
    """Make the server start to play, as a monitor does on a user's command.

    Repeat the call, since the message may be lost. A server started with the default,
    ``server::keepaway_start=-1``, waits for this message; other servers start earlier with it.
    """
    with contextlib.suppress(OSError, ServerError), contextlib.ExitStack() as stack:
        family, address = address_of(host, port)
        sock = stack.enter_context(udp_socket(family))
        sock.sendto(b"(dispinit version 4)\0", address)
        if readable([sock], REPEAT_S):
            _, dedicated = sock.recvfrom(1)
            sock.sendto(b"(dispstart)\0", dedicated)
            sock.sendto(b"(dispbye)\0", dedicated)
