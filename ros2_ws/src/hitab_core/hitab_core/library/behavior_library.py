"""The library: a folder with one readable file for each trained behavior, and all versions.

    Keepaway.hfa.yaml                   the behaviors there are
    ControlBall.hfa.yaml
    .versions/Keepaway/0001.hfa.yaml    what they were before, and are now

A change happens whole or not at all, also when the power fails, and several processes may use
one library at the same time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.errors import LibraryError, has
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.behavior_schema import SUFFIX
from hitab_core.library.change import LibraryChange, read_version
from hitab_core.library.check import misfits
from hitab_core.library.digests import digest_of
from hitab_core.library.durable_files import PATIENCE
from hitab_core.library.edition import Edition, Editions
from hitab_core.library.folder import LibraryFolder
from hitab_core.library.provenance import Provenance, time_now


def accept_edit(path: Path, domain: Domain) -> Path:
    """Take a file as somebody has edited it; see `BehaviorLibrary.accept_edit`."""
    if not path.name.endswith(SUFFIX):
        raise LibraryError(f"{path}: is not a behavior file; these end in {SUFFIX}")
    return BehaviorLibrary(path.parent, domain).accept_edit(path.name.removesuffix(SUFFIX))


class BehaviorLibrary:
    """The behaviors in a folder, trained in one domain.

    Attributes:
        folder: where they are; made when first something is saved.
        domain: with which they were trained.
        problems: what was wrong with files when the library was last loaded, by behavior.
        editions: what reads its files.
        generation: counts the changes that were made through this object.
    """

    def __init__(
        self,
        folder: Path | str,
        domain: Domain,
        *,
        clock: Callable[[], str] = time_now,
        editions: Editions | None = None,
    ) -> None:
        """Name a library; nothing is read yet.

        Args:
            folder: where its files are.
            domain: with which they were trained.
            clock: the time, ISO 8601, that is put into what is saved.
            editions: what reads files; libraries that hold the same should have one in common.
        """
        self.folder = Path(folder)
        self.domain = domain
        self.editions = editions or Editions(domain)
        self.problems: Mapping[str, str] = {}
        self.generation = 0
        self._clock = clock
        self._folder = LibraryFolder(self.folder)
        self._loaded: dict[str, BehaviorFile] | None = None

    # -- reading ----------------------------------------------------------------------------

    def load(self, *, strict: bool = True) -> dict[str, Automaton]:
        """Read all behaviors.

        Args:
            strict: raise if anything is wrong. Otherwise behaviors with something wrong, and
                those that use them, are left out, and `problems` tells what it is.

        Returns:
            The automata, by name.

        Raises:
            LibraryError: if the folder cannot be read; if strict, naming all that is wrong with
                all files.
        """
        with self._folder.held(alone=False):
            loaded, problems = self._read()
        if strict and problems:
            raise LibraryError("\n".join(problems[name] for name in sorted(problems)))
        self._loaded, self.problems = loaded, problems
        return {name: file.automaton for name, file in loaded.items()}

    def edition(self) -> Edition:
        """Read all behaviors, and return them with those of the domain.

        Raises:
            LibraryError: naming all that is wrong with all files.
            VocabularyError: if they do not fit to the domain.
        """
        self.load()
        return self.editions.of(self.files)

    def path(self, name: str) -> Path:
        """Return where the file of a behavior is, or would be.

        Raises:
            LibraryError: if no behavior can have this name.
        """
        return self._folder.file(name)

    @property
    def files(self) -> Mapping[str, BehaviorFile]:
        """What was loaded last, with what was changed here since; loaded now if nothing was."""
        if self._loaded is None:
            self.load()
        return self._loaded or {}

    def names(self) -> list[str]:
        """Return the names of the behaviors in `files`, sorted."""
        return sorted(self.files)

    def file(self, name: str) -> BehaviorFile:
        """Return one behavior with all that its file says.

        Raises:
            LibraryError: if there is none.
        """
        if name not in self.files:
            raise LibraryError(f'{self.folder}: has no behavior "{name}" {has(self.files)}')
        return self.files[name]

    def texts(self) -> dict[str, str]:
        """Return the text of each file, by the behavior's name."""
        return {name: file.text for name, file in self.files.items()}

    @property
    def digest(self) -> str:
        """Digest of all behaviors in `files`."""
        return digest_of(self.checksums)

    @property
    def checksums(self) -> dict[str, str]:
        """Checksum of each behavior in `files`, by name."""
        return {name: file.checksum for name, file in self.files.items()}

    def file_digest(self, name: str) -> str:
        """Return the checksum of one behavior."""
        return self.file(name).checksum

    # -- writing ----------------------------------------------------------------------------

    @contextmanager
    def change(self, *, patience: float = PATIENCE, sync: bool = True) -> Iterator[LibraryChange]:
        """Hold the library to change it; nothing is written unless the change is committed.

        Args:
            patience: seconds to wait for another process to finish with it.
            sync: whether the change will be committed, and not only announced.

        Raises:
            LibraryError: if it cannot be read, or another process does not let go of it.
        """
        with self._folder.held(alone=True, patience=patience, sync=sync):
            there, problems = self._read()
            yield LibraryChange(
                self._folder, self.editions, there, problems, self._clock, self._changed
            )

    def save(
        self,
        automaton: Automaton,
        *,
        classifier: str = "tree",
        agent: str = "",
        author: str = "",
        note: str = "",
    ) -> Path:
        """Add a behavior, or a new version of it.

        Args:
            automaton: trained; its transition functions must be what its examples teach.
            classifier: what learned them.
            agent: the agent that was trained.
            author: who trained it.
            note: anything else worth telling.

        Returns:
            Its file.

        Raises:
            LibraryError: if it does not fit to what is there, or cannot be written; then nothing
                has changed.
        """
        with self.change() as change:
            change.save(automaton, classifier, Provenance(agent=agent, author=author, note=note))
            change.commit()
        return self.path(automaton.name)

    def remove(self, name: str) -> None:
        """Remove a behavior; its versions stay and can be restored.

        Raises:
            LibraryError: if there is none, or others use it.
        """
        with self.change() as change:
            change.remove(name)
            change.commit()

    def accept_edit(self, name: str) -> Path:
        """Take a file as somebody has edited it: check it, and state its digests anew.

        It becomes a new version. Comments that were put into it are lost.

        Returns:
            Its file.

        Raises:
            LibraryError: naming what is wrong with it; then nothing has changed.
        """
        path = self._folder.file(name)
        with self.change() as change:
            text = self._folder.text(path)
            edited = read_behavior(text, path.name, self.domain, accepting=True)
            if name in change.after:
                return path  # nothing is wrong with it
            provenance = replace(edited.provenance, note="edited by hand")
            change.save(edited.automaton, edited.classifier, provenance, edited=True)
            change.commit()
        return path

    def install(self, texts: Mapping[str, str]) -> list[str]:
        """Put files of another library into this one as they are: all, or none.

        Args:
            texts: the files' texts, by the behaviors' names.

        Returns:
            The names of the behaviors that have changed, sorted.

        Raises:
            LibraryError: naming what is wrong; then nothing has changed.
        """
        # Before the folder is made; kept until then, so that they are read once.
        read = [self.editions.read(t, self._folder.file(n).name) for n, t in texts.items()]
        with self.change() as change:
            changed = change.install(texts)
            change.commit()
        del read
        return changed

    def has_saved(self, name: str, checksum: str) -> bool:
        """Return whether a behavior is, or was, saved with this checksum."""
        if name in self.files and self.files[name].checksum == checksum:
            return True
        for number in reversed(self.versions(name)):
            with suppress(LibraryError):
                if self.version(name, number).checksum == checksum:
                    return True
        return False

    # -- versions ---------------------------------------------------------------------------

    def versions(self, name: str) -> list[int]:
        """Return the numbers of all versions of a behavior that there were, ascending."""
        return self._folder.versions(name)

    def version(self, name: str, number: int) -> BehaviorFile:
        """Return one version of a behavior.

        Raises:
            LibraryError: if there is none, or something is wrong with it.
        """
        return read_version(self._folder, self.editions, name, number)

    def restore(self, name: str, number: int) -> Path:
        """Make an earlier version of a behavior the newest one.

        Returns:
            Its file.

        Raises:
            LibraryError: if there is no such version, or it does not fit to what is there now.
        """
        with self.change() as change:
            earlier = change.version(name, number)
            provenance = replace(earlier.provenance, note=f"version {number} restored")
            change.save(earlier.automaton, earlier.classifier, provenance)
            change.commit()
        return self.path(name)

    # -- inside -----------------------------------------------------------------------------

    def _changed(self, change: LibraryChange) -> None:
        self.generation += 1
        if self._loaded is None:
            return
        for name, file in change.changed.items():
            if file is None:
                self._loaded.pop(name, None)
            else:
                self._loaded[name] = file

    def _read(self) -> tuple[dict[str, BehaviorFile], dict[str, str]]:
        """Read all files, those only that have changed; the folder is held."""
        files: dict[str, BehaviorFile] = {}
        problems: dict[str, str] = {}
        for name in self._folder.names():
            try:
                path = self._folder.file(name)
                files[name] = self.editions.read(self._folder.text(path), path.name)
            except LibraryError as error:
                problems[name] = str(error)
        if not problems and self.editions.knows(files):
            return files, {}
        problems |= misfits(files, self.domain, problems)
        return {name: file for name, file in files.items() if name not in problems}, problems
