"""The web server: NiceGUI and the stream of frames, behind the access control."""

from __future__ import annotations

import logging
import socket
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from urllib.parse import unquote

from fastapi import HTTPException, Request, WebSocket
from fastapi.responses import FileResponse

from hitab_client import SwarmError
from hitab_client.recording.recordings import recording
from hitab_studio.access import AccessControl, is_loopback
from hitab_studio.pages.ui_remedies import error_text
from hitab_studio.robots.topics import Options
from hitab_studio.swarm.launcher import NONE
from hitab_studio.swarm.swarm_finder import Finder

STUDIO_TITLE = "HiTAB studio"
DEMONSTRATOR = "hitab_demonstrator"
"""Cookie with the name of the person."""

FREEZES = "hitab_freezes"
"""Cookie that is set if the first key of a behavior pauses the world."""

ICON = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 32 32">'
    '<rect width="32" height="32" rx="8" fill="#2458c5"/>'
    '<circle cx="11" cy="12" r="4.2" fill="#fff"/><circle cx="21" cy="21" r="4.2"'
    ' fill="none" stroke="#fff" stroke-width="2.4"/><path d="M14 14.6 18 18.4" stroke="#fff"'
    ' stroke-width="2.4" stroke-linecap="round"/></svg>'
)


@dataclass(frozen=True)
class Address:
    """The address at which the page is served.

    Attributes:
        host, port: address and port to listen on.
        token: required to open the page; "" if only this machine can reach the page.
        allowed: further host names of the page, such as the name of a proxy.
        root_path: path under which a proxy serves the page, such as ``/hitab``; "" for the root.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    token: str = ""
    allowed: tuple[str, ...] = ()
    root_path: str = ""

    @property
    def url(self) -> str:
        """The URL to open."""
        name = "127.0.0.1" if self.host in ("0.0.0.0", "::", "") else self.host
        shown = f"[{name}]" if ":" in name else name
        suffix = f"/?token={self.token}" if self.token else "/"
        return f"http://{shown}:{self.port}{suffix}"

    def check(self) -> None:
        """Refuse an address that cannot be served safely.

        Raises:
            SwarmError: if other machines can reach an address without a token, or the address is
                in use.
        """
        if not is_loopback(self.host) and not self.token:
            raise SwarmError(
                f"{self.host} can be reached from other machines: a token is needed; give --token"
            )
        family = socket.AF_INET6 if ":" in self.host else socket.AF_INET
        with socket.socket(family) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            try:
                probe.bind((self.host, self.port))
            except OSError as error:
                raise SwarmError(
                    f"{self.host}:{self.port} cannot be used ({error.strerror}); "
                    "choose another with --port"
                ) from None


def serve(
    find: Finder,
    address: Address,
    *,
    startable: Mapping[str, str] = NONE,
    show: bool = False,
    ready: Callable[[], None] | None = None,
    options: Options | None = None,
) -> None:
    """Serve the page until the process is stopped.

    Args:
        find: returns the swarm to connect to.
        address: at which the page is served.
        startable: descriptions of the swarms that pages may start, by name.
        show: whether to open a browser.
        ready: called once the page can be opened.
        options: the chosen topics of robots.

    Raises:
        SwarmError: if the address cannot be used.
    """
    address.check()
    from nicegui import Client, app, ui

    from hitab_studio.actions.stop_actions import stop_robots
    from hitab_studio.pages.page_view import STATIC, PageView
    from hitab_studio.stream import stream
    from hitab_studio.studio import Studio

    logging.getLogger("nicegui").setLevel(logging.ERROR)
    studio = Studio(find, startable, find.choose, options)
    app.add_static_files("/_studio", STATIC, max_cache_age=0)
    app.add_middleware(
        AccessControl,
        host=address.host,
        token=address.token,
        allowed=address.allowed,
        root_path=address.root_path,
    )

    @app.websocket("/field")
    async def field(socket: WebSocket, page: str = "") -> None:
        await stream(studio, socket, page)

    @app.post("/stop-robots")
    async def stop(request: Request, page: str = "") -> None:
        """Engage the emergency stop, also for a page opened before a restart of the server."""
        known = studio.pages.get(page)
        stopping = known or studio.open(unquote(request.cookies.get(DEMONSTRATOR, "")))
        try:
            await stop_robots(stopping)
        except SwarmError as error:
            raise HTTPException(503, error_text(error)) from None
        finally:
            if known is None:
                studio.close(stopping)

    @app.post("/leave")
    def leave(page: str = "") -> None:
        """Close a page that a person has left, without waiting for a reconnection."""
        if (left := studio.pages.get(page)) is not None:
            left.leave()

    @app.get("/recordings/{name}")
    def download(name: str) -> FileResponse:
        try:
            path = recording(name)
        except SwarmError as error:
            raise HTTPException(404, str(error)) from None
        return FileResponse(path, filename=path.name)

    @ui.page("/", title=STUDIO_TITLE, response_timeout=10.0)
    def index(client: Client, request: Request) -> None:
        demonstrator = unquote(request.cookies.get(DEMONSTRATOR, ""))
        freezes = bool(request.cookies.get(FREEZES))
        PageView(studio, studio.open(demonstrator, freezes=freezes), client)

    app.on_startup(studio.start)
    app.on_shutdown(studio.stop)
    if ready is not None:
        app.on_startup(ready)
    ui.run(
        host=address.host,
        port=address.port,
        title=STUDIO_TITLE,
        favicon=ICON,
        dark=None,
        reload=False,
        show=address.url if show else False,
        show_welcome_message=False,
        tailwind=False,
        reconnect_timeout=30.0,  # else a busy browser or bad Wi-Fi reloads the page
        uvicorn_logging_level="error",
        gzip_middleware_factory=None,
        ws_per_message_deflate=False,  # places hardly get shorter, and it takes most of the time
        binding_refresh_interval=None,
    )
