"""The swarm that the options of `hitab up`, or the arguments of the launch file, describe."""

from __future__ import annotations

from pathlib import Path

from hitab_bringup.library_choice import with_library
from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.swarm_file import read_swarm
from hitab_client.shipped import find_file


def described_swarm(
    swarm: str,
    run_dir: Path | None,
    *,
    namespace: str = "",
    use_sim_time: bool = False,
    pace: str = "",
    paused: bool = False,
    library: str = "",
) -> SwarmDescription:
    """Return the swarm that the options describe, see `hitab_bringup.verbs.swarm.up`."""
    described = read_swarm(find_file(swarm, "swarms", "swarm"), run_dir)
    if namespace:
        described = described.in_namespace(namespace)
    if use_sim_time:
        described = described.with_sim_time()
    if pace:
        described = described.with_world(pace=pace)
    if paused:
        described = described.with_world(paused=True)
    return with_library(described, library) if library else described
