"""How late the commands of the people at the pages come, and for when a command counts."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from hitab_msgs.msg import WorldState, WorldStatus

from hitab_client import WorldClient, reaction_time

EARLIER_SECONDS = 0.2
"""By how much a person has a command be due earlier with one key, in seconds of their own."""


class Reactions:
    """The reaction times kept on this machine, read again whenever they have changed."""

    def __init__(self) -> None:
        self._read: tuple[Path, int, dict[str, float]] | None = None

    def of(self, demonstrator: str) -> float:
        """Return a demonstrator's reaction time, s; 0 if none is kept.

        Raises:
            SwarmError: if the file that keeps them cannot be read.
        """
        path = reaction_time.file()
        changed = path.stat().st_mtime_ns if path.exists() else 0
        if self._read is None or self._read[:2] != (path, changed):
            self._read = (path, changed, dict(reaction_time.kept()))
        return self._read[2].get(demonstrator, 0.0)


@dataclass(frozen=True)
class Due:
    """For when a command counts.

    Attributes:
        ago: seconds of simulated time before what the person saw.
        seen: the world's cycle that the person saw; 0: the last one.
    """

    ago: float
    seen: int


def due(world: WorldClient, reaction: float, seen: int) -> Due:
    """Return for when a command counts.

    Args:
        world: that the person sees.
        reaction: the person's reaction time, s.
        seen: the cycle that the page showed; 0: unknown.
    """
    status = world.status
    if status is not None and status.mode == WorldState.PAUSED:
        return Due(0.0, 0)  # the situation has waited for the person
    return Due(reaction_time.simulated(reaction, status, world.speed), seen)


def earlier(world: WorldClient) -> float:
    """Return the simulated time by which one key has a command be due earlier, s.

    A person may pause the world to correct: what counts is its pace when it runs.
    """
    status = world.status
    if status is not None:
        status = WorldStatus(mode=WorldState.RUNNING, pace=status.pace, factor=status.factor)
    return reaction_time.simulated(EARLIER_SECONDS, status, world.speed) or EARLIER_SECONDS
