"""Has a server begin to play, as a monitor does whose user says so."""

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
    """Have the server begin to play; if that is lost on the way, it has to be done again.

    A server that was started with ``server::keepaway_start=-1``, as it is by default, waits for
    it; another one begins earlier than it would have.
    """
    with contextlib.suppress(OSError, ServerError), contextlib.ExitStack() as stack:
        family, address = address_of(host, port)
        sock = stack.enter_context(udp_socket(family))
        sock.sendto(b"(dispinit version 4)\0", address)
        if readable([sock], ANSWER_SECONDS):
            _, dedicated = sock.recvfrom(1)
            sock.sendto(b"(dispstart)\0", dedicated)
            sock.sendto(b"(dispbye)\0", dedicated)
