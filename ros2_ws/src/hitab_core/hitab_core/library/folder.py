"""The files of a library: where they are and how they change, whatever their contents."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from hitab_core.automaton import RESERVED
from hitab_core.errors import LibraryError
from hitab_core.library.behavior_file import SUFFIX, file_name
from hitab_core.library.commit import announce, commit, finish, is_unfinished
from hitab_core.library.durable_files import PATIENCE, file_errors, locked, make_folder
from hitab_core.library.yaml_places import read_text
from hitab_core.use import NAME, NAME_RULE

VERSIONS = ".versions"

Changes = Mapping[str, bytes | None]
"""New contents of files, by path in the folder; None: remove the file."""


class LibraryFolder:
    """A folder of behavior files and all their versions.

    Anything that reads or writes more than one file must hold the lock, see `held`.
    """

    def __init__(self, path: Path) -> None:
        """Open a folder, which may be missing."""
        self.path = path

    @contextmanager
    def held(
        self, *, alone: bool, patience: float = PATIENCE, sync: bool = True
    ) -> Iterator[None]:
        """Lock the folder: exclusively (``alone``) to write, or shared to read. Do not nest.

        A pending change is carried out first.

        Args:
            alone: lock exclusively, to write.
            patience: seconds to wait for other processes.
            sync: if the folder is made, sync it to disk.

        Raises:
            LibraryError: if it cannot be made, or another process keeps it locked.
        """
        with file_errors(self.path, "use"):
            if alone:
                make_folder(self.path, sync=sync)
            is_there = self.path.exists()
        if not is_there:
            yield
            return
        while True:
            with locked(self.path, alone=alone, patience=patience):
                if alone:
                    finish(self.path)
                if alone or not is_unfinished(self.path):
                    yield
                    return
            with locked(self.path, alone=True, patience=patience):
                finish(self.path)

    def names(self) -> list[str]:
        """Return the names of the behaviors that have a file, sorted."""
        return sorted(_names(self.path))

    def text(self, path: Path) -> str:
        """Return the text of a file in the folder.

        Raises:
            LibraryError: if it cannot be read, is not text or is too large.
        """
        return read_text(path)

    def file(self, name: str) -> Path:
        """Return where the file of a behavior is, or would be.

        Raises:
            LibraryError: if no behavior can have this name.
        """
        if name in RESERVED:
            raise LibraryError(f'no behavior can be called "{name}", which is reserved')
        if NAME.match(name) is None:
            raise LibraryError(f'no behavior can be called "{name}"; {NAME_RULE}')
        return self.path / file_name(name)

    def versions(self, name: str) -> list[int]:
        """Return the numbers of the versions of a behavior, ascending."""
        self.file(name)  # which refuses what is no name
        return sorted(int(n) for n in _names(self.path / VERSIONS / name) if n.isdecimal())

    def version_file(self, name: str, number: int) -> Path:
        """Return where a version of a behavior is, or would be."""
        return self.path / _version(name, number)

    def unkept(self, name: str, number: int = 0) -> Changes:
        """Return the change that keeps a behavior's file as a version, unless one equals it.

        Files may be added or edited by other means.

        Args:
            name: of the behavior.
            number: preferred number of the version, if it is free.
        """
        path = self.file(name)
        with file_errors(path, "read"):
            if not path.exists():
                return {}
            data = path.read_bytes()
            numbers = self.versions(name)
            newest = [n for n in (number,) if n in numbers]  # the likely match, so check it first
            for n in (*newest, *reversed(numbers)):
                if self.version_file(name, n).read_bytes() == data:
                    return {}
        return {_version(name, max([number, 1, *(n + 1 for n in numbers)])): data}

    def next_number(self, name: str, planned: Changes) -> int:
        """Return the number of the next version after the ``planned`` changes."""
        kept = [int(Path(p).name.removesuffix(SUFFIX)) for p in planned if _is_of(p, name)]
        return 1 + max([0, *self.versions(name), *kept])

    def addition(self, name: str, number: int, text: str) -> Changes:
        """Return the change that makes ``text`` a behavior's file and keeps it as a version."""
        data = text.encode()
        return {_version(name, number): data, self.file(name).name: data}

    def change(self, changes: Changes) -> None:
        """Make changes: all or none.

        Raises:
            LibraryError: if they cannot be made; nothing has changed.
        """
        commit(self.path, changes)

    def announce(self, changes: Changes) -> bytes:
        """Make changes that other processes see at once and that are carried out later.

        Returns:
            The note that identifies them; see `hitab_core.library.commit.announce`.

        Raises:
            LibraryError: if they cannot be made; nothing has changed.
        """
        return announce(self.path, changes)


def _version(name: str, number: int) -> str:
    return f"{VERSIONS}/{name}/{number:04}{SUFFIX}"


def _is_of(path: str, name: str) -> bool:
    return path.startswith(f"{VERSIONS}/{name}/")


def _names(folder: Path) -> list[str]:
    with file_errors(folder, "read"):
        try:
            found = os.listdir(folder)
        except FileNotFoundError:
            return []
    return [
        name.removesuffix(SUFFIX)
        for name in found
        if name.endswith(SUFFIX) and not name.startswith(".")
    ]
