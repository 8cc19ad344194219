"""Library folders of a swarm's agents: filled, before the first start, from another one."""

from __future__ import annotations

import shutil
from pathlib import Path

from hitab_bringup.swarm_description import SwarmDescription
from hitab_bringup.swarm_processes import library_of


def fill_libraries(swarm: SwarmDescription, folder: Path) -> None:
    """Make every agent's library folder; copy what it starts from into those that are new."""
    for agent in swarm.agents:
        library = library_of(agent, folder)
        library.mkdir(parents=True, exist_ok=True)
        if agent.start_from is not None and not any(library.iterdir()):
            copy_library(agent.start_from, library)


def copy_library(source: Path, destination: Path) -> None:
    """Copy the behavior files of a library, without their earlier versions."""
    destination.mkdir(parents=True, exist_ok=True)
    for path in sorted(source.iterdir()):
        if path.is_file() and not path.name.startswith("."):
            shutil.copyfile(path, destination / path.name)
