"""Answering services: a refusal is a reply, too."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_core import HitabError
from hitab_ros.plain_text import plain
from hitab_ros.recent_requests import RecentRequests

Serve = Callable[[Any, Any], str]
"""Does what a request asks for, fills in the response, and returns its message."""


def what_went_wrong(error: Exception) -> str:
    """Say an error in words, with its place if it is not a user's but one in the code."""
    try:
        said = str(error)
    except Exception:  # an error of somebody else's
        said = "(it cannot be said)"
    if isinstance(error, HitabError):
        return plain(said)
    places = traceback.extract_tb(error.__traceback__)
    place = f" in {Path(places[-1].filename).name}:{places[-1].lineno}" if places else ""
    return plain(f"{type(error).__name__}{place}: {said}")


def answering(
    serve: Serve, answered: Callable[[str], None] = lambda error: None
) -> Callable[[Any, Any], Any]:
    """Return a service's callback, to be made on a `GuardedNode`, which answers what it raises.

    A request with a number (fields ``request`` and ``client``) that is sent again is not done
    again: it gets the same reply.

    Args:
        serve: what the service does; what it raises becomes the reply's message.
        answered: called before the reply is sent, with the error, or "" if all went well.
    """
    recent: RecentRequests[Any] = RecentRequests()

    def answer(request: Any, response: Any) -> Any:
        number, client = getattr(request, "request", 0), getattr(request, "client", "")
        given = recent.came_of(client, number)
        if isinstance(given, Exception):
            raise given
        if given is not None:
            return given
        try:
            response.message = serve(request, response)
            response.success = True
        except Exception as error:
            recent.keep(client, number, error)
            answered(what_went_wrong(error))
            raise
        recent.keep(client, number, response)
        answered("")
        return response

    return answer
