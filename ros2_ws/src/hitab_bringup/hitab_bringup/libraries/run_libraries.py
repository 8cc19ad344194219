"""Library folders of a swarm's agents, filled before the first start."""

from __future__ import annotations

import json
import os
import shutil
import tempfile
from collections.abc import Iterable
from pathlib import Path

from hitab_bringup.libraries.unsaved_trainings import bring_back, set_aside
from hitab_bringup.processes.swarm_processes import kind_file, library_of, write_rosters
from hitab_bringup.swarm_files.swarm_description import AgentDescription, SwarmDescription
from hitab_client.runs.run_folder import LIBRARIES, WORLD_FILES, libraries_of
from hitab_commander import KIND_FILE, kind_text
from hitab_core import each_once


def fill_libraries(members: Iterable[AgentDescription], folder: Path) -> None:
    """Make the library folder of every member; fill new ones from `start_from`."""
    for agent in members:
        library = library_of(agent, folder)
        library.mkdir(parents=True, exist_ok=True)
        if agent.start_from is not None and not any(library.iterdir()):
            _fill(library, agent.start_from)


def _fill(library: Path, source: Path) -> None:
    """Copy all files or none: an incomplete copy would look like a trained library."""
    with tempfile.TemporaryDirectory(dir=library.parent, prefix=f".{library.name}-") as folder:
        copy = Path(folder) / library.name
        copy_library(source, copy)
        copy.replace(library)  # replaces the empty folder


def prepare(swarm: SwarmDescription, folder: Path) -> None:
    """Write everything that the swarm's processes need to a run folder.

    These files are libraries, the members of each host, and the kinds of commanders, which are
    also written to the commanders' libraries for reference. Rosters and kinds are those of the
    whole swarm, since this machine may take over the others' processes.
    """
    fill_libraries(swarm.members_here, folder)
    write_rosters(swarm, folder)
    used = {member.name: str(library_of(member, folder)) for member in swarm.members_here}
    libraries = {agent: Path(library) for agent, library in used.items()}
    set_aside(libraries_of(folder), libraries, folder)
    (folder / LIBRARIES).write_text(json.dumps(used, indent=1) + "\n", encoding="utf-8")
    worlds = sorted({agent.domain for agent in swarm.agents if agent.domain.endswith(".py")})
    (folder / WORLD_FILES).write_text(json.dumps(worlds) + "\n", encoding="utf-8")
    bring_back(libraries, folder)
    for commander in swarm.commanders:
        files = [kind_file(commander, folder)]
        if commander.name in used:
            files.append(library_of(commander, folder) / KIND_FILE)
        for file in files:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(kind_text(commander.kind), encoding="utf-8")


def read_only(folder: Path) -> list[str]:
    """Return sentences about the libraries in a run folder to which nothing can be saved."""
    return each_once(
        (agent, f"nothing can be saved to {library}: it is read-only; choose another --library")
        for agent, library in libraries_of(folder).items()
        if not os.access(library, os.W_OK | os.X_OK)
    )


def copy_library(source: Path, destination: Path) -> None:
    """Copy the behavior files of a library, without their earlier versions."""
    destination.mkdir(parents=True, exist_ok=True)
    for path in sorted(source.iterdir()):
        if path.is_file() and not path.name.startswith("."):
            shutil.copyfile(path, destination / path.name)
