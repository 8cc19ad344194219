"""For when commands count: the person's reaction time, and commands that were due earlier."""

from __future__ import annotations

from dataclasses import dataclass

from hitab_msgs.msg import WorldState, WorldStatus

from hitab_client import reaction_time
from hitab_client.world_client import WorldClient

EARLIER_SECONDS = 0.2
"""By how much a person has a command be due earlier with one key, in seconds of their own."""


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
        seen: the cycle that the person saw; 0: unknown.
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
