"""The stream of moments to one page: always the newest moment, however slow the page is."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import suppress

from fastapi import WebSocket, WebSocketDisconnect

from hitab_studio.page_state import PageState
from hitab_studio.studio import Studio

UNKNOWN_PAGE = 4404
BROWSER = "hitab_browser"
"""Name of the cookie with the identity of the browser."""


async def stream(studio: Studio, socket: WebSocket, key: str) -> None:
    """Send moments until the page goes."""
    session = studio.sessions.get(key)
    await socket.accept()
    if session is None:
        await socket.close(UNKNOWN_PAGE)
        return
    session.connected = True
    session.belong(socket.cookies.get(BROWSER, session.browser))
    studio.store.touch()
    studio.link.viewing.pages.add(key)
    session.show_again()
    session.send({"t": "chosen", "names": session.chosen})
    sending = asyncio.create_task(_send(socket, session))
    try:
        while True:
            await socket.receive_text()  # ends with the connection
    except (WebSocketDisconnect, RuntimeError):
        pass
    finally:
        session.connected = False
        studio.link.viewing.pages.discard(key)
        studio.store.touch()
        sending.cancel()


async def _send(socket: WebSocket, session: PageState) -> None:
    session.sent = b""
    layers: Mapping[str, bytes] = {}
    with suppress(WebSocketDisconnect):
        while True:
            await session.news.wait()
            session.news.clear()
            while session.outgoing:
                await socket.send_text(session.outgoing.popleft())
            try:
                newest = session.frame()
            except Exception as error:
                session.stop_replay(error)
                continue
            if newest and newest is not session.sent:
                session.sent = newest
                await socket.send_bytes(newest)
            before, layers = layers, session.layers()
            for name, data in layers.items():
                if data is not before.get(name):
                    await socket.send_bytes(data)
