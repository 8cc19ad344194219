"""What the agents of a process have learned, as files of a run folder."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path

from hitab_bringup import SwarmDescription, fill_libraries
from hitab_core.library.durable_files import sync_together


class LearnedFiles:
    """The libraries and trainings of a swarm's agents, by process.

    Args:
        swarm: the swarm's description.
        run_folder: the run folder.
    """

    def __init__(self, swarm: SwarmDescription, run_folder: Path) -> None:
        self._swarm = swarm
        self._folder = run_folder

    def is_of(self, process: str) -> Callable[[str], bool]:
        """Return a function that tells whether a path is of an agent of a process."""
        places = tuple(self._places(process))
        return lambda path: any(path == it or path.startswith(f"{it}/") for it in places)

    def _places(self, process: str) -> Iterator[str]:
        for member in self._swarm.members:
            if member.process == process:
                yield f"state/{member.name}"
                yield f"state/restart/{member.name}.json"
        yield from self._libraries(process)

    def _libraries(self, process: str) -> dict[str, None]:
        return {
            f"libraries/{member.library_name or process}": None
            for member in self._swarm.members
            if member.process == process and member.library is None
        }

    def install(self, process: str, source: Path, is_here: Callable[[str], bool]) -> Iterator[str]:
        """Replace the files of a process by a copy of another machine's; yield what is lost.

        What was learned here before and differs is kept, in the folder ``replaced``.

        Args:
            process: name of the process.
            source: folder with the copy.
            is_here: whether a process runs on this machine.
        """
        others = {member.process for member in self._swarm.members} - {process}
        used = {
            library for other in others if is_here(other) for library in self._libraries(other)
        }
        installed = []
        for place in self._places(process):
            if place in used:
                yield f"{place}: the agents of {process} use that of this machine"
            elif (source / place).exists():
                installed.append(self._replace(source / place, self._folder / place))
        fill_libraries((m for m in self._swarm.members if m.process == process), self._folder)
        sync_together(
            path for place in installed for path in (place, *place.rglob("*"), place.parent)
        )

    def _replace(self, source: Path, place: Path) -> Path:
        fresh = place.with_name(f".{place.name}.fresh")
        if fresh.is_dir():
            shutil.rmtree(fresh)
        (shutil.copytree if source.is_dir() else shutil.copyfile)(source, fresh)
        place.parent.mkdir(parents=True, exist_ok=True)
        if place.exists():
            inner = place.relative_to(self._folder)
            kept = self._folder / "replaced" / inner
            number = 1
            while kept.exists():
                number += 1
                kept = kept.with_name(f"{inner.name}.{number}")
            kept.parent.mkdir(parents=True, exist_ok=True)
            place.rename(kept)
        fresh.rename(place)
        return place
