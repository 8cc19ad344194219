"""Answers service requests; a refusal is also a reply."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_core import HitabError
from hitab_ros.plain_text import plain
from hitab_ros.recent_requests import RecentRequests

Serve = Callable[[Any, Any], str]
"""Carries out a request, fills in the response and returns its message."""


def what_went_wrong(error: Exception) -> str:
    """Describe an error, with its place in the code unless it is a user's error."""
    try:
        said = str(error)
    except Exception:  # a foreign error without a usable text
        said = "(no description)"
    if isinstance(error, HitabError):
        return plain(said)
    places = traceback.extract_tb(error.__traceback__)
    place = f" in {Path(places[-1].filename).name}:{places[-1].lineno}" if places else ""
    return plain(f"{type(error).__name__}{place}: {said}")


def answering(
    serve: Serve, answered: Callable[[str], None] = lambda error: None
) -> Callable[[Any, Any], Any]:
    """Return a service callback, for use on a `GuardedNode`, which answers with any exception.

    A repeated request with a number (fields ``request`` and ``client``) is not carried out again:
    it gets the same reply.

    Args:
        serve: carries out a request; the text of its exception becomes the reply's message.
        answered: called before the reply is sent, with the error, or "" on success.
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
