"""Makes a server start to play, as a monitor does on a user's command."""

from __future__ import annotations

import contextlib

from keepaway_world.rcss.connection import (
    ANSWER_SECONDS,
    ServerError,
    address_of,
    readable,
    udp_socket,
)


def kick_off(host: str, port: int) -> None:
    """Make the server start to play; repeat the call if the message is lost.

    A server started with ``server::keepaway_start=-1``, the default, waits for it; another one
    starts earlier than it would have.
    """
    with contextlib.suppress(OSError, ServerError), contextlib.ExitStack() as stack:
        family, address = address_of(host, port)
        sock = stack.enter_context(udp_socket(family))
        sock.sendto(b"(dispinit version 4)\0", address)
        if readable([sock], ANSWER_SECONDS):
            _, dedicated = sock.recvfrom(1)
            sock.sendto(b"(dispstart)\0", dedicated)
            sock.sendto(b"(dispbye)\0", dedicated)
