"""Errors of this package that a user has to fix."""

from __future__ import annotations

from typing import Any

from hitab_core import HitabError, Remedy


class DescriptionError(HitabError):
    """A swarm description that cannot be used."""


class LessonError(HitabError):
    """A lesson that is malformed or fails one of its checks."""


class SwarmError(HitabError):
    """A swarm that does not start, does not answer or refuses."""


def refused(answer: Any, where: str = "") -> SwarmError:
    """Return the error for a refusing answer of a service.

    Args:
        answer: with its message and remedies.
        where: who refused.
    """
    from hitab_ros.conversions import remedies_of  # here because the help imports this module

    return SwarmError(answer.message, *remedies_of(answer.remedies), where=where)


class NamesTakenError(SwarmError):
    """A swarm whose names are in use by other nodes in its ROS domain.

    Attributes:
        domain_id: the ROS domain.
        owner: of the names, such as ``swarm keepaway-3f9a2c1e``.
    """

    def __init__(self, what: str, *remedies: Remedy, domain_id: int, owner: str) -> None:
        super().__init__(what, *remedies)
        self.domain_id = domain_id
        self.owner = owner
