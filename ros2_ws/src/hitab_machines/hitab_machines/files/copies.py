"""Copies of the other machines' libraries and trainings, for the case that a machine is lost."""

from __future__ import annotations

import contextlib
import itertools
import os
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from hitab_msgs.msg import MachineFile
from hitab_msgs.srv import ReadFiles

from hitab_core import HitabError
from hitab_machines.files.shared_files import READ_MAX, SharedFiles, digest_of, safe_path
from hitab_machines.node.jobs import Jobs
from hitab_ros import names
from hitab_ros.call import RequestRefused, SwarmError
from hitab_ros.names import WORLD
from hitab_ros.timing import REPEAT_S

COPIED = ("libraries", "state")
"""Folders in a run folder with what agents have learned."""

PROBLEMS_MAX = 3
"""Maximum number of files that an error names."""


def copied_folders(run_folder: Path) -> SharedFiles:
    """Return the files of a run folder, or of a copy of one, that machines copy."""
    # The state of a world changes in each cycle, and is nothing that an agent has learned.
    return SharedFiles({name: run_folder / name for name in COPIED}, without=(f"state/{WORLD}",))


class Copies:
    """Copies of what the agents of other machines have learned, below a folder.

    Args:
        folder: the folder.
        jobs: makes the calls.
        prefix: namespace of the swarm.
    """

    def __init__(self, folder: Path, jobs: Jobs, prefix: str) -> None:
        self._folder = folder
        self._jobs = jobs
        self._prefix = prefix
        self._files: dict[str, SharedFiles] = {}
        self._tokens: dict[str, str] = {}
        self._next: dict[str, float] = {}

    def of(self, machine: str) -> Path:
        """Return the folder with the copy of a machine's files."""
        return self._folder / safe_path(machine)

    def age(self, machine: str) -> float | None:
        """Return the time since a copy was last as its machine, s; None without a copy."""
        with contextlib.suppress(OSError):
            return time.time() - self._mark(machine).stat().st_mtime
        return None

    def missing(self, machine: str, wanted: Callable[[str], bool]) -> list[str]:
        """Return the wanted files of a machine that its last copy had, and that are gone."""
        listed = self._mark(machine).read_text(encoding="utf-8").splitlines()
        return [path for path in listed if wanted(path) and not (self.of(machine) / path).exists()]

    def follow(self, machine: str, token: str) -> None:
        """Copy what has changed in a machine's files.

        Args:
            machine: name of the machine, which is heard.
            token: text from the machine that changes with its files.
        """
        if self._tokens.get(machine) == token:
            with contextlib.suppress(OSError):
                os.utime(self._mark(machine))
        elif time.monotonic() > self._next.get(machine, 0.0):
            self._next[machine] = time.monotonic() + REPEAT_S
            self._jobs.start(f"copy of {machine}", self._follow(machine, token))

    async def _follow(self, machine: str, token: str) -> None:
        paths = await self.bring(machine)
        self._mark(machine).parent.mkdir(parents=True, exist_ok=True)
        self._mark(machine).write_text("\n".join(paths), encoding="utf-8")
        self._tokens[machine] = token

    async def bring(
        self, machine: str, wanted: Callable[[str], bool] = lambda path: True
    ) -> list[str]:
        """Copy what has changed in the wanted files of a machine, and return their paths.

        Raises:
            SwarmError: if the machine does not answer, or a file cannot be copied; the others are.
        """
        problems: list[str] = []
        local = self._files.setdefault(machine, copied_folders(self.of(machine)))
        listed = {
            file.path: file.digest
            for file in await self.read(machine, ReadFiles.Request.RUN)
            if safe_path(file.path).parts[0] in COPIED and wanted(file.path)
        }
        have = local.digests()
        for gone in have.keys() - listed.keys():
            if wanted(gone):
                (self.of(machine) / gone).unlink(missing_ok=True)
        for folders in _batches(listed, have):
            while folders:
                paths = [path for _, files in folders for path in files]
                try:
                    answer = await self.read(machine, ReadFiles.Request.RUN, paths)
                except RequestRefused as error:
                    answer, why = (), error.problem
                else:
                    why = f"{folders[0][0]} is too large to be copied from {machine}"
                found = {file.path: file for file in answer}
                whole = [files for _, files in folders if found.keys() >= {*files}]
                if not whole:
                    problems.append(why)
                    folders = folders[1:]
                for files in whole:
                    _install(self.of(machine), [found[path] for path in files])
                folders = folders[len(whole) :]
        if problems:
            raise SwarmError("; ".join(problems[:PROBLEMS_MAX]))
        return [*listed]

    async def read(self, machine: str, kind: str, paths: list[str] | None = None) -> Any:
        """Return the files of a machine: a list, or the contents of some.

        Raises:
            SwarmError: if the machine does not answer.
        """
        answer = await self._jobs.call.coroutine(
            ReadFiles,
            names.of_agent(machine, names.READ_FILES, self._prefix),
            ReadFiles.Request(kind=kind, paths=paths or []),
            missing=lambda: SwarmError(f"the machine {machine} offers no files"),
            where=machine,
        )
        return answer.files

    def _mark(self, machine: str) -> Path:
        return self.of(machine).with_name(f"{machine}.copied")


def _batches(
    listed: Mapping[str, str], have: Mapping[str, str]
) -> Iterator[list[tuple[str, list[str]]]]:
    """Yield the folders with changes, each with its files, as many as fit into a request.

    Trainings are copied with all files of their folder, since these belong together.
    """
    batch: list[tuple[str, list[str]]] = []
    count = 0
    ordered = sorted(listed, key=lambda path: path.rpartition("/"))
    for folder, paths in itertools.groupby(ordered, lambda path: path.rpartition("/")[0]):
        files = list(paths)
        changed = [path for path in files if have.get(path) != listed[path]]
        if not changed:
            continue
        belong_together = any(path.endswith(".db") for path in files)
        chosen = files if belong_together else changed
        for start in range(0, len(chosen), READ_MAX):
            part = chosen[start : start + READ_MAX]
            if count + len(part) > READ_MAX:
                yield batch
                batch, count = [], 0
            batch.append((folder, part))
            count += len(part)
    if batch:
        yield batch


def _install(folder: Path, files: list[MachineFile]) -> None:
    """Write files that belong together; a log of a database without it says nothing."""
    for file in sorted(files, key=lambda file: file.path):
        data = bytes(file.data)
        if digest_of(data) != file.digest:
            raise HitabError(f"{file.path} has arrived damaged; try again")
        path = folder / safe_path(file.path)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.with_name(f"{path.name}-wal").unlink(missing_ok=True)
        partial = path.with_name(f".{path.name}.partial")
        partial.write_bytes(data)
        partial.replace(path)
