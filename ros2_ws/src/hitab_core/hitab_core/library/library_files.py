"""The files of a library: where they are, how they change, and what they hold."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from hitab_core.automaton import RESERVED_NAMES
from hitab_core.errors import LibraryError
from hitab_core.library.behavior_file import BEHAVIOR_SUFFIX, BehaviorFile, file_name
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.check import misfits
from hitab_core.library.commit import Changes
from hitab_core.library.contents import LibraryContents, LostBehaviors
from hitab_core.library.durable_files import file_errors
from hitab_core.library.loaded_library import LibraryReader, LoadedLibrary
from hitab_core.library.yaml_places import read_text
from hitab_core.use import VOCABULARY_NAME, VOCABULARY_NAME_RULE
from hitab_core.vocabulary import has

VERSIONS = ".versions"


class LibraryFiles:
    """The behavior files in a folder and all their versions, read for one domain.

    Whatever reads or writes more than one file must hold the lock, see `commit.held`.

    Attributes:
        path: of the folder, which may be missing.
        reader: reads the files.
    """

    def __init__(self, path: Path, reader: LibraryReader) -> None:
        self.path = path
        self.reader = reader

    def names(self) -> list[str]:
        """Return the names of the behaviors that have a file, sorted."""
        return sorted(_names(self.path))

    def file(self, name: str) -> Path:
        """Return where the file of a behavior is, or would be.

        Raises:
            LibraryError: if no behavior can have this name.
        """
        if name in RESERVED_NAMES:
            raise LibraryError(f'no behavior can be called "{name}", which is reserved')
        if VOCABULARY_NAME.match(name) is None:
            raise LibraryError(f'no behavior can be called "{name}"; {VOCABULARY_NAME_RULE}')
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
        kept = [
            int(Path(p).name.removesuffix(BEHAVIOR_SUFFIX)) for p in planned if _is_of(p, name)
        ]
        return 1 + max([0, *self.versions(name), *kept])

    def addition(self, name: str, number: int, text: str) -> Changes:
        """Return the change that makes ``text`` a behavior's file and keeps it as a version."""
        data = text.encode()
        return {_version(name, number): data, self.file(name).name: data}

    # -- what they hold ---------------------------------------------------------------------

    def contents(self) -> LibraryContents:
        """Read all files, reusing unchanged ones."""
        readable: dict[str, BehaviorFile] = {}
        unreadable: dict[str, LibraryError] = {}
        for name in self.names():
            try:
                path = self.file(name)
                readable[name] = self.reader.read(read_text(path), path.name)
            except LibraryError as error:
                unreadable[name] = error
        return self.contents_of(readable, unreadable)

    def contents_of(
        self, readable: Mapping[str, BehaviorFile], unreadable: Mapping[str, LibraryError]
    ) -> LibraryContents:
        """Sort files by whether they can be used; those of a known loaded library can."""
        if not unreadable and self.reader.knows(readable):
            return LibraryContents(readable, {}, {}, {})
        wrong, lost = misfits(readable, self.reader.domain, unreadable, self.sound_version)
        problems = {name: error.problem for name, error in unreadable.items()}
        return LibraryContents(readable, unreadable, problems | wrong, lost)

    def loaded(self, contents: LibraryContents) -> LoadedLibrary:
        """Return the loaded library of some contents.

        Raises:
            VocabularyError: if the behaviors do not fit the domain.
        """
        return self.reader.of(contents.usable, self.losses(contents))

    def losses(self, contents: LibraryContents) -> LostBehaviors:
        """Return what is lost of some contents, with the ways out."""
        return contents.losses(self.path, self.sound_version)

    def version(self, name: str, number: int) -> BehaviorFile:
        """Return one version of a behavior.

        Raises:
            LibraryError: if it is missing or faulty.
        """
        versions = self.versions(name)
        if number not in versions:
            there = f'{self.path}: has no version {number} of "{name}" {has(versions)}'
            raise LibraryError(there)
        path = self.version_file(name, number)
        domain = self.reader.domain
        return read_behavior(read_text(path), f"{name}/{path.name}", domain, name=name)

    def sound_version(self, name: str) -> int | None:
        """Return the newest version of a behavior that can be read; None if there is none."""
        with suppress(LibraryError):
            for number in reversed(self.versions(name)):
                with suppress(LibraryError):
                    self.version(name, number)
                    return number
        return None


def _version(name: str, number: int) -> str:
    return f"{VERSIONS}/{name}/{number:04}{BEHAVIOR_SUFFIX}"


def _is_of(path: str, name: str) -> bool:
    return path.startswith(f"{VERSIONS}/{name}/")


def _names(folder: Path) -> list[str]:
    with file_errors(folder, "read"):
        try:
            found = os.listdir(folder)
        except FileNotFoundError:
            return []
    return [
        name.removesuffix(BEHAVIOR_SUFFIX)
        for name in found
        if name.endswith(BEHAVIOR_SUFFIX) and not name.startswith(".")
    ]
