"""Errors of this package that a user has to mend."""

from hitab_core import HitabError


class DescriptionError(HitabError):
    """A swarm description that cannot be used."""


class LessonError(HitabError):
    """A lesson that is malformed, or whose outcome is not what it expects."""


class SwarmError(HitabError):
    """A swarm that does not start, does not answer or refuses."""


class NamesTakenError(SwarmError):
    """A swarm whose names other nodes have in its ROS domain."""
