"""The actions by name, and performing one safely."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hitab_core import HitabError
from hitab_studio.remedy_words import told
from hitab_studio.session import Session

Data = Mapping[str, Any]
Action = Callable[[Session, Data], Awaitable[None]]

ACTIONS: dict[str, Action] = {}
REPEATED: set[str] = set()
"""Actions that fast clicking repeats."""

URGENT: set[str] = set()
"""Actions that wait for no other one."""


def action(
    name: str, *, repeats: bool = False, urgent: bool = False
) -> Callable[[Action], Action]:
    """Register a function as the action with this name.

    Args:
        name: used by pages.
        repeats: whether a double click performs it twice; otherwise once.
        urgent: whether it is performed at once, whatever the page has asked for before.
    """

    def register(function: Action) -> Action:
        ACTIONS[name] = function
        if repeats:
            REPEATED.add(name)
        if urgent:
            URGENT.add(name)
        return function

    return register


def is_urgent(data: Any) -> bool:
    """Whether a request of a page is to be handled at once."""
    return isinstance(data, Mapping) and data.get("do") in URGENT


class RequestQueue:
    """The pending requests of a page, in order, without unintended repetitions.

    The second click of a double click is dropped, and so is a request that is pending already,
    because the person has seen no answer yet. Repeating actions are never dropped.

    Attributes:
        waiting: the request being handled, and those after it.
    """

    def __init__(self) -> None:
        self._queue: asyncio.Queue[Data | None] = asyncio.Queue()
        self.waiting: list[Data] = []

    def add(self, data: Any) -> None:
        """Add a request of the page."""
        if not isinstance(data, Mapping):
            return
        asked = {key: value for key, value in data.items() if key != "again"}
        pending = any(_same(asked, other) for other in self.waiting)
        if asked.get("do") not in REPEATED and (data.get("again") or pending):
            return
        self.waiting.append(asked)
        self._queue.put_nowait(asked)

    def close(self) -> None:
        """Stop after the present request and drop the others: the page has gone."""
        while not self._queue.empty():
            self._queue.get_nowait()
        self._queue.put_nowait(None)

    async def perform(self, session: Session, done: Callable[[], None]) -> None:
        """Handle one request after the other until the page has gone.

        Args:
            session: of the page.
            done: called after each.
        """
        while (data := await self._queue.get()) is not None:
            await perform(session, data)
            self.waiting.remove(data)
            done()


def _same(one: Data, other: Data) -> bool:
    """Whether two requests ask the same, whatever the page showed meanwhile."""
    return {**one, "seen": 0} == {**other, "seen": 0}


def refuse(session: Session, why: str, kind: str = "bad") -> None:
    """Say why something was not done: in the dialog that asks for it, else as a message."""
    if session.dialog:
        session.dialog["refused"] = why
    else:
        session.tell(why, kind)


async def perform(session: Session, data: Data) -> None:
    """Handle a request of a page; show errors on it."""
    wanted = ACTIONS.get(str(data.get("do")))
    if wanted is None:
        session.tell(f"Unknown action {data.get('do')}", "bad")
        return
    session.dialog.pop("refused", None)
    try:
        await wanted(session, data)
    except HitabError as error:
        refuse(session, told(error))
    except Exception as error:
        logging.getLogger(__name__).exception("action %s", data.get("do"))
        refuse(session, f"That did not work: {error}")
    session.touch()
