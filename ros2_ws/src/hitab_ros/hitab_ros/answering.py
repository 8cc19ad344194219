"""Answers to service requests; a refusal is also a reply."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from hitab_core import HitabError, Remedy
from hitab_core.training.operation import Outcomes
from hitab_ros.messages.plain_text import plain

Serve = Callable[[Any, Any], str]
"""Carries out a request, fills in the response and returns its message."""


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
        response.message = what_went_wrong(error)
    if hasattr(response, "remedies"):
        from hitab_ros.messages.conversions import remedy_messages  # slow: it needs numpy

        response.remedies = remedy_messages(remedies_for(error))
    return response


def answering(serve: Serve) -> Callable[[Any, Any], Any]:
    """Return a service callback for a `GuardedNode`.

    A request that is sent again, with the same ``id``, is not carried out again once it has
    succeeded, but gets the same reply.

    Args:
        serve: carries out a request; the text of its exception becomes the reply's message.
    """
    outcomes = Outcomes()

    def answer(request: Any, response: Any) -> Any:
        given = outcomes.get(request.id)
        if given is not None:
            return given
        response.message = serve(request, response)
        response.success = True
        outcomes.keep(request.id, response)
        return response

    return answer
