"""The library: a folder with a readable file per trained behavior, and all versions.

    Keepaway.hfa.yaml                   the current behaviors
    ControlBall.hfa.yaml
    .versions/Keepaway/0001.hfa.yaml    all versions, including the current one

Changes are atomic, even if the power fails, and several processes may use a library at the same
time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from hitab_core.automaton import Automaton
from hitab_core.domain import Domain
from hitab_core.library.behavior_file import BehaviorFile
from hitab_core.library.change import LibraryChange
from hitab_core.library.commit import held
from hitab_core.library.contents import LibraryContents
from hitab_core.library.digests import digest_of
from hitab_core.library.durable_files import LOCK_TIMEOUT_S
from hitab_core.library.expectation import Expectation
from hitab_core.library.library_files import LibraryFiles
from hitab_core.library.loaded_library import LibraryReader, LoadedLibrary
from hitab_core.library.provenance import Provenance, time_now
from hitab_core.library.renaming import plan_renaming
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.vocabulary import has


class BehaviorLibrary:
    """The behaviors in a folder, trained in one domain.

    Attributes:
        folder: folder of the files; made on the first save.
        domain: domain in which the behaviors were trained.
        reader: reads the files.
        on_disk: the files themselves, with all versions.
        generation: number of changes made through this object.
    """

    def __init__(
        self,
        folder: Path | str,
        domain: Domain,
        *,
        clock: Callable[[], str] = time_now,
        reader: LibraryReader | None = None,
    ) -> None:
        """Open a library without reading anything yet.

        Args:
            folder: folder of the files.
            domain: domain in which the behaviors were trained.
            clock: returns the time, ISO 8601, to record in saved files.
            reader: reads the files; libraries with equal contents should share one.
        """
        self.folder = Path(folder)
        self.domain = domain
        self.reader = reader or LibraryReader(domain)
        self.generation = 0
        self._clock = clock
        self.on_disk = LibraryFiles(self.folder, self.reader)
        self._contents: LibraryContents | None = None

    # -- reading ----------------------------------------------------------------------------

    def load(self, *, strict: bool = True) -> dict[str, Automaton]:
        """Read all behaviors.

        Args:
            strict: raise if anything is wrong. Otherwise leave out the behaviors that cannot be
                used and list their faults in `problems`.

        Returns:
            The automata, by name.

        Raises:
            LibraryError: if the folder cannot be read; if strict, naming every fault in every
                file.
        """
        return {name: file.automaton for name, file in self._load(strict).usable.items()}

    def _load(self, strict: bool) -> LibraryContents:
        with held(self.folder, alone=False):
            contents = self.on_disk.contents()
        problems = contents.problems
        if strict and problems:
            raise LibraryError("\n".join(problems[name] for name in sorted(problems)))
        self._contents = contents
        return contents

    def loaded(self, *, strict: bool = True) -> LoadedLibrary:
        """Read all behaviors, and return them with the domain's behaviors.

        Args:
            strict: raise if there is any fault. Otherwise the loaded library lists lost behaviors.

        Raises:
            LibraryError: if the folder cannot be read; if strict, naming every fault in every
                file.
            VocabularyError: if they do not fit the domain.
        """
        return self.on_disk.loaded(self._load(strict))

    @property
    def files(self) -> Mapping[str, BehaviorFile]:
        """The usable files at the last load or change; loads them if there was none."""
        return (self._contents or self._load(strict=True)).usable

    @property
    def problems(self) -> Mapping[str, str]:
        """Faults of the other behaviors at that time, by behavior."""
        return {} if self._contents is None else self._contents.problems

    def file(self, name: str) -> BehaviorFile:
        """Return one behavior file.

        Raises:
            LibraryError: if there is none.
        """
        if name not in self.files:
            raise LibraryError(f'{self.folder}: has no behavior "{name}" {has(self.files, name)}')
        return self.files[name]

    def texts(self) -> dict[str, str]:
        """Return the text of each file, by behavior name."""
        return {name: file.text for name, file in self.files.items()}

    @property
    def digest(self) -> str:
        """Digest of the learned behaviors in `files`."""
        return digest_of({name: file.learned for name, file in self.files.items()})

    # -- writing ----------------------------------------------------------------------------

    @contextmanager
    def change(self, *, patience: float = LOCK_TIMEOUT_S) -> Iterator[LibraryChange]:
        """Lock the library to change it; nothing is written unless the change is committed.

        Args:
            patience: seconds to wait for another process to finish with it.

        Raises:
            LibraryError: if it cannot be read, or another process keeps it locked.
        """
        with held(self.folder, alone=True, patience=patience):
            yield LibraryChange(self.on_disk, self._clock, self._changed)

    def save(
        self,
        automaton: Automaton,
        *,
        classifier: str = "tree",
        agent: str = "",
        note: str = "",
    ) -> Path:
        """Add a behavior, or a new version of it.

        Args:
            automaton: trained; its transition functions must follow from its examples.
            classifier: classifier that learned the functions.
            agent: the agent that was trained.
            note: free text.

        Returns:
            Its file.

        Raises:
            LibraryError: if it does not fit the library, or cannot be written; nothing has
                changed.
        """
        with self.change() as change:
            change.save(automaton, classifier, Provenance(agent=agent, note=note))
            change.commit()
        return self.on_disk.file(automaton.name)

    def remove(self, name: str, *, anyway: bool = False) -> list[str]:
        """Remove a behavior; its versions stay and can be restored.

        Args:
            name: name of the behavior, which may be lost.
            anyway: remove it even if others can no longer be used then.

        Returns:
            The names of the behaviors that cannot be used without it.

        Raises:
            LibraryError: if it is missing, or other behaviors use it.
        """
        with self.change() as change:
            users = change.remove(name, anyway=anyway)
            change.commit()
        return users

    def rename(
        self, old: str, new: str, *, with_users: bool = False
    ) -> tuple[list[str], list[str]]:
        """Rename a behavior, and on request in the behaviors that use it; see `plan_renaming`.

        Raises:
            LibraryError: naming the obstacle; nothing has changed.
        """
        with self.change() as change:
            done = plan_renaming(change, self.domain, old, new, with_users=with_users)
            change.commit()
        return done

    def expect(self, name: str, expectations: Sequence[Expectation]) -> BehaviorFile:
        """Replace the expectations of a behavior; return its new version.

        Raises:
            LibraryError: if there is no such behavior, or it breaks one that blocks.
        """
        with self.change() as change:
            file = change.before.usable.get(name) or self.file(name)
            provenance = replace(file.provenance, note="expectations changed")
            saved = change.save(
                file.automaton, file.classifier, provenance, expectations=expectations
            )
            change.commit()
        return saved

    def install(self, texts: Mapping[str, str]) -> list[str]:
        """Copy files of another library into this one unchanged: all or none.

        Args:
            texts: texts of the files, by behavior name.

        Returns:
            The names of the changed behaviors, sorted.

        Raises:
            LibraryError: naming the faults; nothing has changed.
        """
        with self.change() as change:
            changed = change.install(texts)
            change.commit()
        return changed

    def has_saved(self, name: str, checksum: str) -> bool:
        """Return whether any version of a behavior has this checksum."""
        if name in self.files and self.files[name].checksum == checksum:
            return True
        for number in reversed(self.on_disk.versions(name)):
            with suppress(LibraryError):
                if self.on_disk.version(name, number).checksum == checksum:
                    return True
        return False

    def restore(self, name: str, number: int) -> Path:
        """Make an earlier version of a behavior the newest one.

        Returns:
            Its file.

        Raises:
            LibraryError: if there is no such version, or it does not fit the library now.
        """
        with self.change() as change:
            earlier = self.on_disk.version(name, number)
            provenance = replace(earlier.provenance, note=f"version {number} restored")
            kept = change.before.readable.get(name, earlier).expectations
            change.save(
                earlier.automaton,
                earlier.classifier,
                provenance,
                restored=True,
                expectations=kept,
            )
            change.commit()
        return self.on_disk.file(name)

    # -- inside -----------------------------------------------------------------------------

    def _changed(self, change: LibraryChange) -> None:
        self.generation += 1
        self._contents = change.contents
