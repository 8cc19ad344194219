"""Swarm descriptions from the options of `hitab up`, or the launch file's arguments."""

from __future__ import annotations

import json
from pathlib import Path

from hitab_bringup.libraries.library_choice import with_library
from hitab_bringup.swarm_files.swarm_description import SwarmDescription
from hitab_bringup.swarm_files.swarm_file import parse_swarm, read_swarm
from hitab_client.runs.shipped import find_file
from hitab_core import VOCABULARY_NAME, HitabError
from hitab_world import simulation_in


def described_swarm(
    swarm: str,
    run_dir: Path | None,
    *,
    namespace: str = "",
    use_sim_time: bool = False,
    pace: str = "",
    paused: bool = False,
    library: str = "",
    machine: str | None = None,
    agents: int = 0,
) -> SwarmDescription:
    """Return the swarm that the options of `hitab up` describe.

    Args:
        machine: the machine whose part is to be started; None for the whole swarm.
    """
    if swarm.endswith(".py"):
        described = _of_simulation(Path(swarm).resolve(), agents, run_dir)
    elif agents:
        raise HitabError(f"--agents is for a world in one file; {swarm} lists its agents itself")
    else:
        described = read_swarm(_file(swarm), run_dir)
    if namespace:
        described = described.in_namespace(namespace)
    if use_sim_time:
        described = described.with_sim_time()
    if pace:
        described = described.with_world(pace=pace)
    if paused:
        described = described.with_world(paused=True)
    if machine is not None:
        described = described.on_machine(machine)
    if not library:
        return described
    if described.machines:
        raise HitabError(
            f"{swarm}: each machine keeps the libraries of its agents in its run folder; leave "
            "out --library, and write `start_from:` in the swarm file"
        )
    return with_library(described, library)


def _file(swarm: str) -> Path:
    try:
        return find_file(swarm, "swarms", "swarm")
    except HitabError as error:
        if VOCABULARY_NAME.match(swarm) is None:
            raise
        way = "if another machine has the file, say which this is: --machine NAME"
        raise HitabError(f"{error}; {way}") from None


def _of_simulation(path: Path, agents: int, run_dir: Path | None) -> SwarmDescription:
    """Return the swarm of a file with a `hitab_world.Simulation`."""
    count = agents or simulation_in(path).agents
    swarm = {
        "swarm": path.stem,
        "world": {"kind": str(path)},
        "agents": {"agent": {"count": count}},
    }
    return parse_swarm(json.dumps(swarm), path, run_dir)
