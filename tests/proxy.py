"""A reverse proxy, as small as can be: below a path, which it cuts off, for HTTP and web sockets.

The studio gets the address of the proxy's own connection as `Host`, as nginx sends it by default.
"""

from __future__ import annotations

import contextlib
import socket
import threading
from collections.abc import Iterator

PATH = "/hitab"


@contextlib.contextmanager
def proxy(port: int) -> Iterator[str]:
    """Yield the address below which the page of a port of this machine is shown."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        threading.Thread(target=_serve, args=(server, port), daemon=True).start()
        yield f"http://localhost:{server.getsockname()[1]}{PATH}/"


def _serve(server: socket.socket, port: int) -> None:
    with contextlib.suppress(OSError):  # the server is closed
        while True:
            threading.Thread(target=_hand_on, args=(server.accept()[0], port), daemon=True).start()


def _hand_on(browser: socket.socket, port: int) -> None:
    """Hand on one request, and whatever comes after it in a web socket."""
    with browser, contextlib.suppress(OSError):
        head = b""
        while b"\r\n\r\n" not in head:
            if not (data := browser.recv(65536)):
                return
            head += data
        lines, rest = head.split(b"\r\n\r\n", 1)
        first, *fields = lines.decode().split("\r\n")
        kept = [f for f in fields if not f.lower().startswith(("host:", "connection:"))]
        kind = "Upgrade" if any(f.lower().startswith("upgrade:") for f in kept) else "close"
        told = [
            first.replace(f"{PATH}/", "/", 1),
            f"Host: 127.0.0.1:{port}",
            f"Connection: {kind}",
        ]
        with socket.create_connection(("127.0.0.1", port)) as studio:
            studio.sendall("\r\n".join([*told, *kept]).encode() + b"\r\n\r\n" + rest)
            threading.Thread(target=_pump, args=(browser, studio), daemon=True).start()
            _pump(studio, browser)


def _pump(source: socket.socket, target: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while data := source.recv(65536):
            target.sendall(data)
        target.shutdown(socket.SHUT_WR)
