"""Which swarm the studio talks to: it may not be up yet, and may be another one a moment later."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from hitab_bringup.domain_ids import chosen_by_user
from hitab_bringup.run_folder import RunFolder, RunRecord, running_swarms


@dataclass(frozen=True)
class Target:
    """A swarm, or just a ROS domain in which there may be one.

    Attributes:
        domain_id: its ROS domain.
        swarm: its name; empty if nobody says.
        agents: those that there should be.
        start: a number that another start of the same swarm does not have.
        problem: why it is not certain which swarm is meant, or "".
    """

    domain_id: int
    swarm: str = ""
    agents: tuple[str, ...] = ()
    start: int = 0
    problem: str = ""


def find_target(swarm: str | None = None, run_folder: Path | None = None) -> Target:
    """Return the swarm in this folder, of this name, or the one that is up.

    Args:
        swarm: its name.
        run_folder: of a swarm that was started by this process and is not listed.
    """
    own = chosen_by_user()
    if run_folder is not None:
        folder = RunFolder(run_folder)
        record = folder.read()
        return _target(record) if record is not None else Target(own or 0)
    up = [record for _, record in running_swarms()]
    if swarm is not None:
        named = [record for record in up if record.swarm == swarm]
        if named:
            return _target(named[0])
        return Target(own or 0, swarm, problem=f'Swarm "{swarm}" is not up.')
    if own is not None:
        here = [record for record in up if record.domain_id == own]
        return _target(here[0]) if len(here) == 1 else Target(own)
    if len(up) == 1:
        return _target(up[0])
    if up:
        names = ", ".join(record.swarm for record in up)
        return Target(
            0, problem=f"Several swarms are up ({names}): start the studio with the name of one."
        )
    return Target(0)


def _target(record: RunRecord) -> Target:
    return Target(record.domain_id, record.swarm, record.agents, record.supervisor)


def describe(target: Target) -> str:
    """Return what a person calls it."""
    name = target.swarm or f"ROS domain {target.domain_id}"
    return f"{name} ({os.uname().nodename})"
