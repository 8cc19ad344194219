"""Errors of this package that a user has to fix."""

from __future__ import annotations

from collections.abc import Sequence

from hitab_core import HitabError

NAMED_MAX = 5  # maximum number of names in an error


def some(names: Sequence[str]) -> str:
    """Return the first names of many, for an error: ``a, b, c, d, e and 3 more``."""
    more = len(names) - NAMED_MAX
    return ", ".join(names[:NAMED_MAX]) + (f" and {more} more" if more > 0 else "")


class DescriptionError(HitabError):
    """A swarm description that cannot be used."""


class LessonError(HitabError):
    """A lesson that is malformed or fails one of its checks."""


class SwarmError(HitabError):
    """A swarm that does not start, does not answer or refuses."""


class NamesTakenError(SwarmError):
    """A swarm whose names are in use by other nodes in its ROS domain."""
