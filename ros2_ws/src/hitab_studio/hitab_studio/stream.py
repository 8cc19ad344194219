"""The stream of frames to one page, which skips frames if the page is slow."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from contextlib import suppress

from fastapi import WebSocket, WebSocketDisconnect

from hitab_studio.pages.page import Page
from hitab_studio.studio import Studio

UNKNOWN_PAGE = 4404
BROWSER = "hitab_browser"
"""Cookie with the identity of the browser."""


async def stream(studio: Studio, socket: WebSocket, key: str) -> None:
    """Send the newest frame until the page disconnects."""
    page = studio.pages.get(key)
    await socket.accept()
    if page is None:
        await socket.close(UNKNOWN_PAGE)
        return
    page.connected = True
    page.assign_browser(socket.cookies.get(BROWSER, page.browser))
    studio.touch()
    page.show_again()
    page.send({"t": "chosen", "names": page.chosen})
    sending = asyncio.create_task(_send(socket, page))
    try:
        while True:
            await socket.receive_text()  # ends with the connection
    except (WebSocketDisconnect, RuntimeError):
        pass
    finally:
        page.connected = False
        studio.touch()
        sending.cancel()


async def _send(socket: WebSocket, page: Page) -> None:
    page.sent = b""
    layers: Mapping[str, bytes] = {}
    with suppress(WebSocketDisconnect):
        while True:
            await page.news.wait()
            page.news.clear()
            while page.outgoing:
                await socket.send_text(page.outgoing.popleft())
            try:
                newest, strip = page.frame(), page.time.new_strip(page)
            except Exception as error:
                page.stop_replay(error)
                continue
            if newest and newest is not page.sent:
                page.sent = newest
                await socket.send_bytes(newest)
            if strip:
                await socket.send_text(strip)
            before, layers = layers, page.layers()
            for name, data in layers.items():
                if data is not before.get(name):
                    await socket.send_bytes(data)
