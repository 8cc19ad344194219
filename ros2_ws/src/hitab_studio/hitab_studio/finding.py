"""Which swarm the studio connects to: it may not be up yet, and may be replaced at any time."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from hitab_client import RunFolder, RunRecord, SwarmError
from hitab_client.domain_ids import chosen_by_user
from hitab_client.run_folder import running_swarms
from hitab_client.swarm_choice import find_meant, meant


@dataclass(frozen=True)
class Target:
    """A swarm, or just a ROS domain that may contain one.

    Attributes:
        domain_id: its ROS domain.
        swarm: its name; empty if unknown.
        identity: of its present start; empty if unknown.
        world: whether it has started a world.
        agents: the agents that it should have.
        start: a number that differs for each start of the same swarm.
        problem: why no swarm can be chosen to connect to; "" if one can.
    """

    domain_id: int
    swarm: str = ""
    agents: tuple[str, ...] = ()
    start: int = 0
    problem: str = ""
    identity: str = ""
    world: bool = False


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
        if record is None or folder.supervisor(record) is None:
            return Target(own or 0, problem=f"No swarm is up in {folder.path}.")
        return _target(record)
    if swarm is not None and not meant(swarm, running_swarms()) and os.sep not in swarm:
        return Target(own or 0, swarm, problem=f'Swarm "{swarm}" is not up.')
    try:
        found = find_meant(swarm, own)
    except SwarmError as error:
        return Target(own or 0, swarm or "", problem=f"{error}.")
    return _target(found[1]) if found is not None else Target(own or 0)


def _target(record: RunRecord) -> Target:
    return Target(
        record.domain_id,
        record.swarm,
        record.agents,
        record.supervisor,
        identity=record.identity,
        world=record.world,
    )


def describe(target: Target) -> str:
    """Return its name for people."""
    name = target.swarm or f"ROS domain {target.domain_id}"
    return f"{name} ({os.uname().nodename})"
