"""Immutable contents of a library, shared by agents with the same behaviors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakValueDictionary

from hitab_core.domain import Domain
from hitab_core.library.behavior_file import BehaviorFile, file_name
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.contents import LostBehaviors
from hitab_core.library.digests import digest_of
from hitab_core.repertoire import Repertoire
from hitab_core.texts.errors import LibraryError

NOTHING_LOST = LostBehaviors()


@dataclass(frozen=True, eq=False)
class LoadedLibrary:
    """Everything an agent has learned: files and their behaviors. Immutable.

    Attributes:
        files: the behavior files that can be used, by name.
        repertoire: these behaviors and the domain's.
        losses: the behaviors that cannot be used.
    """

    files: Mapping[str, BehaviorFile]
    repertoire: Repertoire
    losses: LostBehaviors = NOTHING_LOST

    @cached_property
    def digest(self) -> str:
        """Digest of all learned behaviors."""
        return digest_of({name: file.learned for name, file in self.files.items()})

    @property
    def texts(self) -> dict[str, str]:
        """The text of each file, by behavior name."""
        return {name: file.text for name, file in self.files.items()}


class LibraryReader:
    """Reads each text once and loads equal contents once, for any number of libraries.

    Reading a behavior means learning it again from its examples, so this is a cache. Entries that
    no library uses are dropped.

    Attributes:
        domain: domain in which behaviors were trained.
    """

    def __init__(self, domain: Domain) -> None:
        """Start empty."""
        self.domain = domain
        self._files: WeakValueDictionary[tuple[str, str], BehaviorFile] = WeakValueDictionary()
        self._loaded: WeakValueDictionary[_Key, LoadedLibrary] = WeakValueDictionary()

    def read(self, text: str, file: str) -> BehaviorFile:
        """Return a behavior file; see `read_behavior`.

        Raises:
            LibraryError: naming everything wrong with it.
        """
        found = self._files.get((file, text))
        if found is None:
            found = self._files[file, text] = read_behavior(text, file, self.domain)
        return found

    def read_all(self, texts: Mapping[str, str]) -> dict[str, BehaviorFile]:
        """Return behavior files, given their texts, by name.

        Raises:
            LibraryError: naming everything wrong with each of them.
        """
        files: dict[str, BehaviorFile] = {}
        problems = []
        for name, text in texts.items():
            try:
                files[name] = self.read(text, file_name(name))
            except LibraryError as error:
                problems.append(str(error))
        if problems:
            raise LibraryError("\n".join(problems))
        return files

    def knows(self, files: Mapping[str, BehaviorFile]) -> bool:
        """Return whether these files were loaded together before, so they are known to fit."""
        return _key(files, NOTHING_LOST) in self._loaded

    def of(
        self, files: Mapping[str, BehaviorFile], losses: LostBehaviors = NOTHING_LOST
    ) -> LoadedLibrary:
        """Return the loaded library of these files.

        Args:
            files: files that can be used, by name.
            losses: the behaviors that cannot be used.

        Raises:
            VocabularyError: if they do not fit together, or do not fit the domain.
        """
        key = _key(files, losses)
        found = self._loaded.get(key)
        if found is None:
            automata = {name: file.automaton for name, file in files.items()}
            lost = losses.reasons, losses.unread, losses.remedies
            repertoire = Repertoire(self.domain, automata, *lost)
            found = LoadedLibrary(dict(files), repertoire, losses)
            self._loaded[key] = found
        return found


_Key = tuple[frozenset[tuple[str, str]], tuple[str, ...]]


def _key(files: Mapping[str, BehaviorFile], losses: LostBehaviors) -> _Key:
    return frozenset((name, file.text) for name, file in files.items()), losses.faults
