"""The folder of a library with what reads its files: contents and versions."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress

from hitab_core.errors import LibraryError
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.contents import Contents, Losses
from hitab_core.library.edition import Edition, Editions
from hitab_core.library.folder import LibraryFolder
from hitab_core.vocabulary import has


class Shelf:
    """Behavior files in a folder, read for one domain.

    Attributes:
        folder: of the files; must be locked where it is read.
        editions: reads the files.
    """

    def __init__(self, folder: LibraryFolder, editions: Editions) -> None:
        self.folder = folder
        self.editions = editions

    def contents(self) -> Contents:
        """Read all files, reusing unchanged ones."""
        readable: dict[str, BehaviorFile] = {}
        unreadable: dict[str, LibraryError] = {}
        for name in self.folder.names():
            try:
                path = self.folder.file(name)
                readable[name] = self.editions.read(self.folder.text(path), path.name)
            except LibraryError as error:
                unreadable[name] = error
        return self.contents_of(readable, unreadable)

    def contents_of(
        self, readable: Mapping[str, BehaviorFile], unreadable: Mapping[str, LibraryError]
    ) -> Contents:
        """Sort files by whether they can be used; those of a known edition can."""
        if not unreadable and self.editions.knows(readable):
            return Contents(readable, {}, {}, {})
        return Contents.of(readable, unreadable, self.editions.domain, self.sound_version)

    def edition(self, contents: Contents) -> Edition:
        """Return the edition of some contents.

        Raises:
            VocabularyError: if the behaviors do not fit the domain.
        """
        return self.editions.of(contents.usable, self.losses(contents))

    def losses(self, contents: Contents) -> Losses:
        """Return what is lost of some contents, with the ways out."""
        return contents.losses(self.folder.path, self.sound_version)

    def version(self, name: str, number: int) -> BehaviorFile:
        """Return one version of a behavior.

        Raises:
            LibraryError: if it is missing or faulty.
        """
        folder, versions = self.folder, self.folder.versions(name)
        if number not in versions:
            there = f'{folder.path}: has no version {number} of "{name}" {has(versions)}'
            raise LibraryError(there)
        path = folder.version_file(name, number)
        domain = self.editions.domain
        return read_behavior(folder.text(path), f"{name}/{path.name}", domain, name=name)

    def sound_version(self, name: str) -> int | None:
        """Return the newest version of a behavior that can be read; None if there is none."""
        with suppress(LibraryError):
            for number in reversed(self.folder.versions(name)):
                with suppress(LibraryError):
                    self.version(name, number)
                    return number
        return None
