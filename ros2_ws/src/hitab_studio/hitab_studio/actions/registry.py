"""The actions by name, and performing one safely."""

from __future__ import annotations

import logging
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from hitab_core.errors import HitabError
from hitab_studio.session import Session

Data = Mapping[str, Any]
Action = Callable[[Session, Data], Awaitable[None]]

ACTIONS: dict[str, Action] = {}


def action(name: str) -> Callable[[Action], Action]:
    """Make a function the action of this name."""

    def register(function: Action) -> Action:
        ACTIONS[name] = function
        return function

    return register


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
