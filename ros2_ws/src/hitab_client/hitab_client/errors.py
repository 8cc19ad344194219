"""Errors of this package that a user can fix."""

from __future__ import annotations

from hitab_core import HitabError, Remedy
from hitab_ros.call import SwarmError as SwarmError


class DescriptionError(HitabError):
    """A swarm description that cannot be used."""


class LessonError(HitabError):
    """A lesson that is malformed or fails one of its checks."""


class NamesTakenError(SwarmError):
    """A swarm whose names are in use by other nodes in its ROS domain.

    Attributes:
        domain_id: the ROS domain.
        owner: owner of the names, such as ``swarm keepaway-3f9a2c1e``.
    """

    def __init__(self, what: str, *remedies: Remedy, domain_id: int, owner: str) -> None:
        super().__init__(what, *remedies)
        self.domain_id = domain_id
        self.owner = owner
