"""The files of a library: their places, changes and contents."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

from hitab_core.automaton import RESERVED_NAMES
from hitab_core.library.behavior_file import BEHAVIOR_SUFFIX, BehaviorFile, file_name
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.check import misfits
from hitab_core.library.commit import Changes, files_in
from hitab_core.library.contents import LibraryContents, LostBehaviors
from hitab_core.library.durable_files import file_errors
from hitab_core.library.loaded_library import LibraryReader, LoadedLibrary
from hitab_core.library.yaml_places import read_text
from hitab_core.term import VOCABULARY_NAME, VOCABULARY_NAME_RULE
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.vocabulary import has

VERSIONS = ".versions"


class LibraryFiles:
    """The behavior files in a folder and all their versions, read for one domain.

    A caller that reads or writes more than one file must hold the lock, see `commit.held`.

    Attributes:
        path: path of the folder, which may be missing.
        reader: reads the files.
    """

    def __init__(self, path: Path, reader: LibraryReader) -> None:
        self.path = path
        self.reader = reader

    def names(self) -> list[str]:
        """Return the names of the behaviors that have a file, sorted."""
        return sorted(self._files())

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
        return sorted(self._versions(name))

    def next_number(self, name: str, stated: int) -> int:
        """Return the number of the next version of a behavior.

        Args:
            name: name of the behavior.
            stated: number of the version that its file says to be; 0 if it says none.
        """
        return 1 + max([0, *self._versions(name), *self._unkept(name, stated)])

    def addition(self, name: str, text: str, stated: int) -> tuple[int, Changes]:
        """Return the number of the next version, and the change that makes it from ``text``."""
        kept, data = self._unkept(name, stated), text.encode()
        number = 1 + max([0, *self._versions(name), *kept])
        return number, _kept(name, kept | {number: data}) | {file_name(name): data}

    def removal(self, name: str, stated: int) -> Changes:
        """Return the change that removes a behavior's file, which is kept as a version."""
        return _kept(name, self._unkept(name, stated)) | {file_name(name): None}

    def _unkept(self, name: str, stated: int) -> dict[int, bytes]:
        """Return a behavior's file by its number, unless the newest version equals it.

        Files may be added or edited by other means.
        """
        path = self._files().get(name)
        if path is None:
            return {}
        versions = self._versions(name)
        newest = max(versions, default=0)
        with file_errors(path, "read"):
            data = path.read_bytes()
            if newest and versions[newest].read_bytes() == data:
                return {}
        return {max(stated, newest + 1): data}

    # -- contents ---------------------------------------------------------------------------

    def contents(self) -> LibraryContents:
        """Read all files, reusing unchanged ones."""
        readable: dict[str, BehaviorFile] = {}
        unreadable: dict[str, LibraryError] = {}
        for name, path in sorted(self._files().items()):
            try:
                readable[name] = self.reader.read(read_text(path), self.file(name).name)
            except LibraryError as error:
                unreadable[name] = error
        return self.contents_of(readable, unreadable)

    def contents_of(
        self, readable: Mapping[str, BehaviorFile], unreadable: Mapping[str, LibraryError]
    ) -> LibraryContents:
        """Sort files by whether they can be used; files of a known loaded library can."""
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
        """Return the lost behaviors of some contents, with the ways out."""
        return contents.losses(self.path, self.sound_version)

    def version(self, name: str, number: int) -> BehaviorFile:
        """Return one version of a behavior.

        Raises:
            LibraryError: if it is missing or faulty.
        """
        versions = self._versions(name)
        if number not in versions:
            there = f'{self.path}: has no version {number} of "{name}" {has(sorted(versions))}'
            raise LibraryError(there)
        file = f"{name}/{number:04}{BEHAVIOR_SUFFIX}"
        return read_behavior(read_text(versions[number]), file, self.reader.domain, name=name)

    def sound_version(self, name: str) -> int | None:
        """Return the newest version of a behavior that can be read; None if there is none."""
        with suppress(LibraryError):
            for number in reversed(self.versions(name)):
                with suppress(LibraryError):
                    self.version(name, number)
                    return number
        return None

    # -- where they are ---------------------------------------------------------------------

    def _files(self, inside: str = "") -> dict[str, Path]:
        return {
            name.removesuffix(BEHAVIOR_SUFFIX): path
            for name, path in files_in(self.path, inside).items()
            if name.endswith(BEHAVIOR_SUFFIX) and not name.startswith(".")
        }

    def _versions(self, name: str) -> dict[int, Path]:
        self.file(name)  # raises if it is no name
        found = self._files(f"{VERSIONS}/{name}")
        return {int(number): path for number, path in found.items() if number.isdecimal()}


def _kept(name: str, versions: dict[int, bytes]) -> Changes:
    """Return the change that keeps versions of a behavior, given by number."""
    return {f"{VERSIONS}/{name}/{n:04}{BEHAVIOR_SUFFIX}": data for n, data in versions.items()}
