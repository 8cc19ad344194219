"""All that a library held at one moment, shared by the agents that have learned the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakValueDictionary

from hitab_core.domain import Domain
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.digests import digest_of
from hitab_core.repertoire import Repertoire


@dataclass(frozen=True, eq=False)
class Edition:
    """What an agent has learned: files, and the behaviors that they make. Nothing in it changes.

    Attributes:
        files: the behavior files, by name.
        repertoire: these behaviors with those of the domain.
    """

    files: Mapping[str, BehaviorFile]
    repertoire: Repertoire

    @cached_property
    def digest(self) -> str:
        """Digest of all behaviors in it."""
        return digest_of({name: file.checksum for name, file in self.files.items()})

    @property
    def texts(self) -> dict[str, str]:
        """The text of each file, by the behavior's name."""
        return {name: file.text for name, file in self.files.items()}


class Editions:
    """Reads each text once and makes each edition once, however many libraries hold them.

    Reading a behavior means to learn it again from its examples. What no library holds any more
    is forgotten.

    Attributes:
        domain: with which behaviors were trained.
    """

    def __init__(self, domain: Domain) -> None:
        """Begin with nothing."""
        self.domain = domain
        self._files: WeakValueDictionary[tuple[str, str], BehaviorFile] = WeakValueDictionary()
        self._editions: WeakValueDictionary[frozenset[tuple[str, str]], Edition] = (
            WeakValueDictionary()
        )

    def read(self, text: str, file: str) -> BehaviorFile:
        """Return what a behavior file says; see `read_behavior`.

        Raises:
            LibraryError: naming all that is wrong with it.
        """
        found = self._files.get((file, text))
        if found is None:
            found = self._files[file, text] = read_behavior(text, file, self.domain)
        return found

    def knows(self, files: Mapping[str, BehaviorFile]) -> bool:
        """Return whether these files make an edition that there is, so that they fit together."""
        return _key(files) in self._editions

    def of(self, files: Mapping[str, BehaviorFile]) -> Edition:
        """Return the edition of some files.

        Raises:
            VocabularyError: if they do not fit together, or to the domain.
        """
        key = _key(files)
        found = self._editions.get(key)
        if found is None:
            automata = {name: file.automaton for name, file in files.items()}
            found = Edition(dict(files), Repertoire(self.domain, automata))
            self._editions[key] = found
        return found


def _key(files: Mapping[str, BehaviorFile]) -> frozenset[tuple[str, str]]:
    return frozenset((name, file.text) for name, file in files.items())
