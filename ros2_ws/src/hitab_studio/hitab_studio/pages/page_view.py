"""The page: a canvas for the field, panels rendered by the server, and a queue of requests."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from nicegui import Client, ui
from nicegui.element import Element

from hitab_client import Training
from hitab_core import HitabError
from hitab_core.training.operation import Outcomes
from hitab_ros.answering import what_went_wrong
from hitab_ros.timing import REFRESH_S, REPEAT_S
from hitab_studio.actions import REGISTERED_ACTIONS, REPEATED, URGENT, Data
from hitab_studio.pages.page import Page
from hitab_studio.pages.ui_remedies import error_text
from hitab_studio.studio import Studio
from hitab_studio.views import PANELS, render

STATIC = Path(__file__).parents[1] / "static"

DRAW_EVERY = 2
"""Refreshes between two drawings of values that change continuously, such as curves."""

PAUSE_FACTOR = 2.0
"""Pause after drawing a page, in multiples of the drawing time and for each open page. It leaves
half of the server's time to commands. Changes made on the page itself are drawn at once."""

CANVAS = (
    'role="application" aria-label="The things in the field. Page Up and Page Down choose one, '
    'the arrow keys move it, and with Alt turn it."'
)


def is_urgent(data: Any) -> bool:
    """Whether a page's request is handled at once, before the pending ones."""
    return isinstance(data, Mapping) and data.get("do") in URGENT


class RequestQueue:
    """The pending requests of a page, in order, without unintended repetitions.

    The second click of a double click is dropped, and so is a repetition of the last pending
    request, because the person has seen no answer yet. Go, Stop, Go are three commands at any
    speed, since no request repeats the one before it. Repeating actions are never dropped.

    A request marked as unavailable is tried nevertheless while the page may lag behind, such as an
    undo right after its command.

    Attributes:
        waiting: the request being handled, then the pending ones.
    """

    def __init__(self) -> None:
        self._queue: asyncio.Queue[Data | None] = asyncio.Queue()
        self.waiting: list[Data] = []
        self._shown_at = 0.0

    def add(self, data: Any) -> None:
        """Add a request of the page."""
        if not isinstance(data, Mapping):
            return
        asked = {key: value for key, value in data.items() if key != "again"}
        off = asked.pop("off", "")
        if off and not self.waiting and time.monotonic() > self._shown_at:
            asked = {"do": "why", "reason": off}
        pending = bool(self.waiting) and _same(asked, self.waiting[-1])
        if asked.get("do") not in REPEATED and (data.get("again") or pending):
            return
        self.waiting.append(asked)
        self._queue.put_nowait(asked)

    def close(self) -> None:
        """Drop the pending requests of a closed page, and stop after the current one."""
        while not self._queue.empty():
            self._queue.get_nowait()
        self._queue.put_nowait(None)

    async def perform(self, page: Page, done: Callable[[], None]) -> None:
        """Handle one request after the other until `close` is called.

        Args:
            page: origin of the requests.
            done: called after each request.
        """
        while (data := await self._queue.get()) is not None:
            await perform(page, data)
            self.waiting.remove(data)
            self._shown_at = time.monotonic() + REPEAT_S
            if not self.waiting:
                page.not_taken.clear()
            done()


def _same(one: Data, other: Data) -> bool:
    """Whether two requests are equal, apart from identity, and cycle and keys that were shown."""
    apart = {"id": "", "seen": 0, "hotkey": ""}
    return {**one, **apart} == {**other, **apart}


async def perform(page: Page, data: Data) -> None:
    """Handle a request of a page, and show errors on the page."""
    wanted = REGISTERED_ACTIONS.get(str(data.get("do")))
    if wanted is None:
        page.tell(f"Unknown action {data.get('do')}", "bad")
        return
    page.dialog.pop("refused", None)
    try:
        await wanted(page, data)
    except HitabError as error:
        page.refuse(error_text(error))
    except Exception as error:
        logging.getLogger(__name__).exception("action %s", data.get("do"))
        page.refuse(f"That did not work: {error}")
    page.touch()


class PagePanel(Element, component="../static/panel.js"):
    """A part of the page with HTML rendered by the server."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self.props["html"] = ""
        self.props["id"] = f"panel-{name}"
        self.name = name

    def show(self, html: str) -> None:
        """Replace the HTML of the panel."""
        if html != self.props["html"]:
            self.props["html"] = html
            self.update()


SHOW_REFUSAL = (
    'addEventListener("load", async () => { const it = await fetch("leave", {method: "POST"});'
    " if (!it.ok) document.body.textContent = await it.text(); });"
)
"""Shows the error on the empty page if the address is refused, such as an unknown proxy's."""


class PageView:
    """A page in a browser: draws the page's state, and handles the person's requests."""

    def __init__(self, studio: Studio, page: Page, client: Client) -> None:
        self._studio = studio
        self._page = page
        self._client = client
        self._seen: tuple[int, int] = (-1, -1)
        self._training: Training | None = None
        self._count = 0
        self._draws_from = 0.0
        self._requests = RequestQueue()
        self._heard = Outcomes()
        self._urgent: set[asyncio.Task[None]] = set()
        self._broken: dict[str, str] = {}
        self._build()

    def _build(self) -> None:
        page = self._page
        ui.add_head_html(
            f'<script>window.STUDIO_PAGE = "{page.id}";{SHOW_REFUSAL}</script>'
            '<link rel="stylesheet" href="_studio/studio.css">'
            '<script type="module" src="_studio/studio.js"></script>'
            '<script type="module" src="_studio/keys.js"></script>'
            '<script type="module" src="_studio/field.js"></script>'
            '<script type="module" src="_studio/tutorial.js"></script>'
        )
        ui.query(".nicegui-content").classes(remove="nicegui-content")
        with ui.element("div").props('id="studio"'):
            self._panels = [PagePanel(name) for name in PANELS if name != "overlay"]
            # NiceGUI's frame around all elements is already the page's <main>.
            with ui.element("section").props('id="stage" aria-label="The field"'):
                ui.element("canvas").props(f'id="field" tabindex="0" {CANVAS}')
                self._panels.append(PagePanel("overlay"))
                ui.element("div").props('id="field-report" role="status"').classes("unseen")
        ui.on("studio", lambda event: self._receive(event.args["requests"]))
        self._refresh()
        ui.timer(REFRESH_S, self._refresh)
        self._performing = asyncio.create_task(self._perform())
        self._client.on_delete(self._requests.close)
        page.leave = self._requests.close

    def _receive(self, requests: Any) -> None:
        """Queue requests, or handle them at once if urgent.

        The page sends all requests that were not confirmed yet, in the person's order, so that
        none is lost with a connection. Those that were heard before are only confirmed.
        """
        for data in requests:
            if data["id"] not in self._heard:
                self._heard.keep(data["id"], data)
                if is_urgent(data):
                    task = asyncio.create_task(perform(self._page, data))
                    self._urgent.add(task)
                    task.add_done_callback(self._urgent.discard)
                else:
                    self._requests.add(data)
        self._page.send({"t": "heard", "id": requests[-1]["id"]})

    async def _perform(self) -> None:
        """Handle requests until the page is closed, and complete the current one."""
        try:
            await self._requests.perform(self._page, self._refresh)
        finally:
            self._studio.close(self._page)

    def _refresh(self) -> None:
        page = self._page
        if page.messages.drop_old():
            page.touch()
        self._count += 1
        seen = (self._studio.version, page.version)
        training = page.training
        begun = time.monotonic()
        if page.version == self._seen[1] and training is self._training:
            is_same = seen == self._seen and self._count % DRAW_EVERY
            if is_same or begun < self._draws_from:
                return
        self._seen, self._training = seen, training
        for panel in self._panels:
            try:
                panel.show(render(panel.name, page))
                self._broken.pop(panel.name, None)
            except Exception as error:  # the other panels and the page continue
                why = what_went_wrong(error)
                if self._broken.get(panel.name) != why:
                    self._broken[panel.name] = why
                    logging.getLogger(__name__).exception("panel %s", panel.name)
                    page.tell(f"A part of the page cannot be shown: {why}", "bad")
        took = time.monotonic() - begun
        self._draws_from = begun + PAUSE_FACTOR * took * len(self._studio.pages)
