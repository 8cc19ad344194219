"""The files of a library: what is where, and how it is changed. What they say is not looked at."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from hitab_core.automaton import RESERVED
from hitab_core.behavior_file import file_name
from hitab_core.behavior_schema import SUFFIX
from hitab_core.durable_files import file_errors, locked, make_folder
from hitab_core.errors import LibraryError
from hitab_core.library_commit import commit, finish, is_unfinished
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

    @contextmanager
    def held(self, *, alone: bool) -> Iterator[None]:
        """Hold the folder: ``alone`` to write, or with others to read. Not to be nested.

        Raises:
            LibraryError: if it cannot be made, or another process does not let go of it.
        """
        with file_errors(self.path, "use"):
            if alone:
                make_folder(self.path)
            is_there = self.path.exists()
        if not is_there:
            yield
            return
        if not alone:
            with locked(self.path, alone=False):
                if not is_unfinished(self.path):
                    yield
                    return
        with locked(self.path, alone=True):
            finish(self.path)
            yield

    def names(self) -> list[str]:
        """Return the names of the behaviors for which there is a file, sorted."""
        return _names(self.path)

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
        folder = self.path / VERSIONS / self.file(name).name.removesuffix(SUFFIX)
        return sorted(int(number) for number in _names(folder) if number.isdecimal())

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
            if any(self.version_file(name, n).read_bytes() == data for n in reversed(numbers)):
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
            LibraryError: if they cannot be made.
        """
        commit(self.path, changes)


def _version(name: str, number: int) -> str:
    return f"{VERSIONS}/{name}/{number:04}{SUFFIX}"


def _is_of(path: str, name: str) -> bool:
    return path.startswith(f"{VERSIONS}/{name}/")


def _names(folder: Path) -> list[str]:
    with file_errors(folder, "read"):
        if not folder.exists():
            return []
        found = [path.name for path in folder.iterdir()]
    return sorted(
        name.removesuffix(SUFFIX)
        for name in found
        if name.endswith(SUFFIX) and not name.startswith(".")
    )
