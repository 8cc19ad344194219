"""The actions by name, and performing one safely."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hitab_core import HitabError
from hitab_studio.session import Session

Data = Mapping[str, Any]
Action = Callable[[Session, Data], Awaitable[None]]

ACTIONS: dict[str, Action] = {}
REPEATED: set[str] = set()
"""Actions that somebody who clicks quickly wants that often."""


def action(name: str, *, repeats: bool = False) -> Callable[[Action], Action]:
    """Make a function the action of this name.

    Args:
        name: that pages use.
        repeats: whether a double click asks for it twice; else it is meant once.
    """

    def register(function: Action) -> Action:
        ACTIONS[name] = function
        if repeats:
            REPEATED.add(name)
        return function

    return register


class Wishes:
    """What a page asks for and is not done yet, in order, without what was not meant.

    The second click of a double click is not meant, nor is what already waits or is being done:
    the person has seen no answer yet. Actions that repeat are meant each time.

    Attributes:
        waiting: what is being done, and what waits for that.
    """

    def __init__(self) -> None:
        self._queue: asyncio.Queue[Data | None] = asyncio.Queue()
        self.waiting: list[Data] = []

    def add(self, data: Any) -> None:
        """Take what the page asks for."""
        if not isinstance(data, Mapping):
            return
        asked = {key: value for key, value in data.items() if key != "again"}
        if asked.get("do") not in REPEATED and (data.get("again") or asked in self.waiting):
            return
        self.waiting.append(asked)
        self._queue.put_nowait(asked)

    def close(self) -> None:
        """End after what is being done: the page has gone, and what waits is not done any more."""
        while not self._queue.empty():
            self._queue.get_nowait()
        self._queue.put_nowait(None)

    async def perform(self, session: Session, done: Callable[[], None]) -> None:
        """Do one thing after the other until the page has gone.

        Args:
            session: of the page.
            done: called after each.
        """
        while (data := await self._queue.get()) is not None:
            await perform(session, data)
            self.waiting.remove(data)
            done()


async def perform(session: Session, data: Data) -> None:
    """Do what a page asks for; tell there what went wrong."""
    wanted = ACTIONS.get(str(data.get("do")))
    if wanted is None:
        session.tell(f"unknown action {data.get('do')}", "bad")
        return
    try:
        await wanted(session, data)
    except HitabError as error:
        session.tell(str(error), "bad")
    except Exception as error:
        logging.getLogger(__name__).exception("action %s", data.get("do"))
        session.tell(f"That did not work: {error}", "bad")
    session.touch()
