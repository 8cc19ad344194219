"""Answers to service requests; a refusal is also a reply."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_core import HitabError, Remedy
from hitab_ros.plain_text import plain
from hitab_ros.recent_requests import RecentRequests

Serve = Callable[[Any, Any], str]
"""Carries out a request, fills in the response and returns its message."""

Answered = Callable[[Exception | None], None]
"""Called with the error of a refused request, or None on success."""


def what_went_wrong(error: Exception) -> str:
    """Return an error's text without remedies; for a fault in the code, with its location."""
    try:
        text = str(error)
    except Exception:  # an error of another library without a usable text
        text = "(no description)"
    if isinstance(error, HitabError):
        return plain(error.problem)
    places = traceback.extract_tb(error.__traceback__)
    place = f" in {Path(places[-1].filename).name}:{places[-1].lineno}" if places else ""
    return plain(f"{type(error).__name__}{place}: {text}")


def remedies_for(error: Exception | None) -> tuple[Remedy, ...]:
    """Return the remedies for an error."""
    return error.remedies if isinstance(error, HitabError) else ()


def refuse(response: Any, error: Exception) -> Any:
    """Write the reason of a refusal into a response, as far as its fields allow."""
    if hasattr(response, "message"):
        from hitab_ros.conversions import remedy_messages  # slow: it needs numpy

        response.message = what_went_wrong(error)
        response.remedies = remedy_messages(remedies_for(error))
    return response


def answering(serve: Serve, answered: Answered = lambda error: None) -> Callable[[Any, Any], Any]:
    """Return a service callback for a `GuardedNode`, which also replies to exceptions.

    A repeated request with a number (fields ``request`` and ``client``) is not carried out again,
    but gets the same reply.

    Args:
        serve: carries out a request; the text of its exception becomes the reply's message.
        answered: called before the reply is sent, with the error, or None on success.
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
            answered(error)
            raise
        recent.keep(client, number, response)
        answered(None)
        return response

    return answer
