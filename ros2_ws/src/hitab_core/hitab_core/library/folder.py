"""The files of a library: what is where, and how it is changed. What they say is not looked at."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from hitab_core.automaton import RESERVED
from hitab_core.errors import LibraryError
from hitab_core.library.behavior_file import file_name
from hitab_core.library.behavior_reader import read_text, text_in
from hitab_core.library.behavior_schema import SUFFIX
from hitab_core.library.commit import announce, commit, finish, is_unfinished, pending
from hitab_core.library.durable_files import PATIENCE, file_errors, locked, make_folder
from hitab_core.use import NAME, NAME_RULE

VERSIONS = ".versions"

Changes = Mapping[str, bytes | None]
"""New contents of files, by path in the folder; None: the file is removed."""


class LibraryFolder:
    """A folder of behavior files and, beside them, of all their versions.

    All that reads or writes more than one file is done while it is `held`.
    """

    def __init__(self, path: Path) -> None:
        """Name a folder, which need not be there yet."""
        self.path = path
        self._pending: Changes = {}

    @contextmanager
    def held(
        self, *, alone: bool, patience: float = PATIENCE, sync: bool = True
    ) -> Iterator[None]:
        """Hold the folder: ``alone`` to write, or with others to read. Not to be nested.

        A change that was made but not carried out is carried out first. Who only reads does not
        need that: where the disk does not allow it, he reads as if it were.

        Args:
            alone: to write, and not only to read.
            patience: seconds to wait for others to let go of it.
            sync: if the folder is made, force it to disk.

        Raises:
            LibraryError: if it cannot be made, or another process does not let go of it.
        """
        with file_errors(self.path, "use"):
            if alone:
                make_folder(self.path, sync=sync)
            is_there = self.path.exists()
        if not is_there:
            yield
            return
        if not alone:
            with locked(self.path, alone=False, patience=patience):
                if not is_unfinished(self.path):
                    yield
                    return
            with suppress(LibraryError), locked(self.path, alone=True, patience=patience):
                finish(self.path)
            with locked(self.path, alone=False, patience=patience):
                self._pending = pending(self.path)
                try:
                    yield
                finally:
                    self._pending = {}
            return
        with locked(self.path, alone=True, patience=patience):
            finish(self.path)
            yield

    def names(self) -> list[str]:
        """Return the names of the behaviors for which there is a file, sorted."""
        return self._names(".")

    def text(self, path: Path) -> str:
        """Return the text of a file in the folder.

        Raises:
            LibraryError: if it cannot be read, is not text or is too large to be a behavior.
        """
        coming = None
        if self._pending:
            coming = self._pending.get(str(path.relative_to(self.path)))
        return read_text(path) if coming is None else text_in(coming, path)

    def file(self, name: str) -> Path:
        """Return where the file of a behavior is, or would be.

        Raises:
            LibraryError: if no behavior can have this name.
        """
        if NAME.match(name) is None or name in RESERVED:
            raise LibraryError(f'{self.path}: no behavior can be called "{name}"; {NAME_RULE}')
        return self.path / file_name(name)

    def versions(self, name: str) -> list[int]:
        """Return the numbers of the versions of a behavior, ascending."""
        inner = f"{VERSIONS}/{self.file(name).name.removesuffix(SUFFIX)}"
        return sorted(int(number) for number in self._names(inner) if number.isdecimal())

    def version_file(self, name: str, number: int) -> Path:
        """Return where a version of a behavior is, or would be."""
        return self.path / _version(name, number)

    def unkept(self, name: str, number: int = 0) -> Changes:
        """Return what keeps the present file of a behavior as a version, if none is like it.

        A file may have been put into the folder or edited by other means.

        Args:
            name: of the behavior.
            number: what the version should be called if that is not taken.
        """
        path = self.file(name)
        with file_errors(path, "read"):
            if not path.exists():
                return {}
            data = path.read_bytes()
            numbers = self.versions(name)
            newest = [n for n in (number,) if n in numbers]  # probably, and then that will do
            for n in (*newest, *reversed(numbers)):
                if self.version_file(name, n).read_bytes() == data:
                    return {}
        return {_version(name, max([number, 1, *(n + 1 for n in numbers)])): data}

    def next_number(self, name: str, planned: Changes) -> int:
        """Return the number of the next version, if ``planned`` is done before."""
        kept = [int(Path(p).name.removesuffix(SUFFIX)) for p in planned if _is_of(p, name)]
        return 1 + max([0, *self.versions(name), *kept])

    def addition(self, name: str, number: int, text: str) -> Changes:
        """Return what makes ``text`` the file of a behavior and keeps it as a version."""
        data = text.encode()
        return {_version(name, number): data, self.file(name).name: data}

    def change(self, changes: Changes) -> None:
        """Make changes: all, or none.

        Raises:
            LibraryError: if they cannot be made; then nothing has changed.
        """
        commit(self.path, changes)

    def announce(self, changes: Changes) -> bytes:
        """Make changes that others see already and that are carried out later.

        Returns:
            The note by which they are known; see `hitab_core.library.commit.announce`.

        Raises:
            LibraryError: if they cannot be made; then nothing has changed.
        """
        return announce(self.path, changes)

    def _names(self, inner: str) -> list[str]:
        """Return the names of behavior files in a folder in this one, sorted."""
        found = set(_names(self.path / inner))
        for path, content in self._pending.items():
            place = Path(path)
            if str(place.parent) == inner and place.name.endswith(SUFFIX):
                name = place.name.removesuffix(SUFFIX)
                found = found - {name} if content is None else found | {name}
        return sorted(found)


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
