"""Answering services so that no mistake, a user's or a programmer's, ends the node.

An exception that leaves a callback ends the process (rclpy's EventsExecutor), and whoever has
asked waits for an answer that does not come.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_core.errors import HitabError
from hitab_ros.recent_requests import RecentRequests

Serve = Callable[[Any, Any], str]
"""Does what a request asks for, fills in the response, and returns its message."""


def what_went_wrong(error: Exception) -> str:
    """Say an error in words, with its place if it is not a user's but one in the code."""
    if isinstance(error, HitabError):
        return str(error)
    place = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__} in {Path(place.filename).name}:{place.lineno}: {error}"


def answering(
    serve: Serve, answered: Callable[[str], None] = lambda error: None
) -> Callable[[Any, Any], Any]:
    """Return a service's callback: a refusal is a reply with ``success`` false and the reason.

    A request with a number (fields ``request`` and ``client``) that is sent again is not done
    again: it gets the same reply.

    Args:
        serve: what the service does; what it raises becomes the reply's message.
        answered: called before the reply is sent, with the error, or "" if all went well.
    """
    recent: RecentRequests[Any] = RecentRequests()

    def answer(request: Any, response: Any) -> Any:
        number, client = getattr(request, "request", 0), getattr(request, "client", "")
        if (given := recent.came_of(client, number)) is not None:
            return given
        error = ""
        try:
            response.message = serve(request, response)
            response.success = True
        except Exception as wrong:
            if not isinstance(wrong, HitabError):
                traceback.print_exception(wrong, file=sys.stderr)  # into the process's log
            response.success = False
            response.message = error = what_went_wrong(wrong)
        recent.keep(client, number, response)
        answered(error)
        return response

    return answer
