"""The library: a folder with one readable file for each trained behavior, and all versions.

    Keepaway.hfa.yaml                   the behaviors there are
    ControlBall.hfa.yaml
    .versions/Keepaway/0001.hfa.yaml    what they were before, and are now

A change happens whole or not at all, also when the power fails, and several processes may use
one library at the same time.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from hitab_core.automaton import Automaton
from hitab_core.behavior_file import (
    BASIC,
    HAND_WRITTEN,
    BehaviorFile,
    file_name,
    text_of,
)
from hitab_core.behavior_reader import read_behavior, read_text
from hitab_core.behavior_schema import SUFFIX
from hitab_core.digests import digest_of
from hitab_core.domain import Domain
from hitab_core.errors import LibraryError, has
from hitab_core.library_check import misfits
from hitab_core.library_folder import Changes, LibraryFolder
from hitab_core.provenance import Provenance, time_now, tool_name


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
    """

    def __init__(
        self, folder: Path | str, domain: Domain, *, clock: Callable[[], str] = time_now
    ) -> None:
        """Name a library; nothing is read yet.

        Args:
            folder: where its files are.
            domain: with which they were trained.
            clock: the time, ISO 8601, that is put into what is saved.
        """
        self.folder = Path(folder)
        self.domain = domain
        self.problems: Mapping[str, str] = {}
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
        provenance = Provenance(agent=agent, author=author, note=note)
        with self._folder.held(alone=True):
            return self._save(automaton, classifier, provenance)

    def remove(self, name: str) -> None:
        """Remove a behavior; its versions stay and can be restored.

        Raises:
            LibraryError: if there is none, or others use it.
        """
        with self._folder.held(alone=True):
            there, _ = self._read()
            if name not in self._folder.names():
                raise LibraryError(
                    f'{self.folder}: has no behavior "{name}" {has(self._folder.names())}'
                )
            users = sorted(n for n, f in there.items() if name in f.automaton.behaviors_used)
            if users and name not in self.domain.automata:
                raise LibraryError(
                    f'{self.folder}: "{name}" cannot be removed, since {", ".join(users)} '
                    "cannot do without it; remove that first"
                )
            self._folder.change({**self._unkept(name, there), file_name(name): None})
            if self._loaded is not None:
                self._loaded.pop(name, None)

    def accept_edit(self, name: str) -> Path:
        """Take a file as somebody has edited it: check it, and state its digests anew.

        It becomes a new version. Comments that were put into it are lost.

        Returns:
            Its file.

        Raises:
            LibraryError: naming what is wrong with it; then nothing has changed.
        """
        path = self._folder.file(name)
        with self._folder.held(alone=True):
            edited = read_behavior(read_text(path), path.name, self.domain, accepting=True)
            there, _ = self._read()
            if name in there:
                return path  # nothing is wrong with it
            provenance = replace(edited.provenance, note="edited by hand")
            return self._save(edited.automaton, edited.classifier, provenance, edited=True)

    def install(self, texts: Mapping[str, str]) -> list[str]:
        """Put files of another library into this one as they are: all, or none.

        Args:
            texts: the files' texts, by the behaviors' names.

        Returns:
            The names of the behaviors that have changed, sorted.

        Raises:
            LibraryError: naming what is wrong; then nothing has changed.
        """
        new = {
            name: read_behavior(text, self._folder.file(name).name, self.domain)
            for name, text in texts.items()
        }
        with self._folder.held(alone=True):
            there, problems = self._read()
            self._check_fit(there, problems, new)
            # By their texts, comments included: senders and receivers compare these.
            changed = sorted(
                name for name in new if name not in there or there[name].text != new[name].text
            )
            changes: dict[str, bytes | None] = {}
            for name in changed:
                changes |= self._unkept(name, there)
                number = self._folder.next_number(name, changes)
                changes |= self._folder.addition(name, number, texts[name])
            if changes:
                self._folder.change(changes)
            if self._loaded is not None:
                self._loaded |= new
        return changed

    # -- versions ---------------------------------------------------------------------------

    def versions(self, name: str) -> list[int]:
        """Return the numbers of all versions of a behavior that there were, ascending."""
        return self._folder.versions(name)

    def version(self, name: str, number: int) -> BehaviorFile:
        """Return one version of a behavior.

        Raises:
            LibraryError: if there is none, or something is wrong with it.
        """
        if number not in self.versions(name):
            raise LibraryError(
                f'{self.folder}: has no version {number} of "{name}" {has(self.versions(name))}'
            )
        path = self._folder.version_file(name, number)
        return read_behavior(read_text(path), f"{name}/{path.name}", self.domain, name=name)

    def restore(self, name: str, number: int) -> Path:
        """Make an earlier version of a behavior the newest one.

        Returns:
            Its file.

        Raises:
            LibraryError: if there is no such version, or it does not fit to what is there now.
        """
        with self._folder.held(alone=True):
            earlier = self.version(name, number)
            provenance = replace(earlier.provenance, note=f"version {number} restored")
            return self._save(earlier.automaton, earlier.classifier, provenance)

    # -- inside, while the folder is held ---------------------------------------------------

    def _read(self) -> tuple[dict[str, BehaviorFile], dict[str, str]]:
        files: dict[str, BehaviorFile] = {}
        problems: dict[str, str] = {}
        for name in self._folder.names():
            try:
                path = self._folder.file(name)
                text = read_text(path)
                before = (self._loaded or {}).get(name)
                if before is not None and before.text == text:
                    files[name] = before
                else:
                    files[name] = read_behavior(text, path.name, self.domain)
            except LibraryError as error:
                problems[name] = str(error)
        problems |= misfits(files, self.domain, problems)
        return {name: file for name, file in files.items() if name not in problems}, problems

    def _save(
        self,
        automaton: Automaton,
        classifier: str,
        provenance: Provenance,
        *,
        edited: bool = False,
    ) -> Path:
        name = automaton.name
        path = self._folder.file(name)
        there, problems = self._read()
        # What was edited becomes the new version and need not be kept as one before it.
        kept = {} if edited else self._unkept(name, there)
        number = self._folder.next_number(name, kept)
        text = text_of(
            automaton,
            self.domain,
            classifier=classifier,
            uses={used: self._as_it_is(used, there) for used in automaton.behaviors_used},
            provenance=replace(
                provenance,
                version=max(number, provenance.version + 1) if edited else number,
                created=self._clock(),
                tool=tool_name(),
                earlier=self._earlier(name, there),
            ),
        )
        try:
            new = read_behavior(text, path.name, self.domain)
        except LibraryError as error:
            raise LibraryError(f'"{name}" cannot be saved:\n{error}') from None
        self._check_fit(there, problems, {name: new})
        self._folder.change({**kept, **self._folder.addition(name, new.provenance.version, text)})
        if self._loaded is not None:
            self._loaded[name] = new
        return path

    def _unkept(self, name: str, there: Mapping[str, BehaviorFile]) -> Changes:
        return self._folder.unkept(name, there[name].provenance.version if name in there else 0)

    def _as_it_is(self, used: str, there: Mapping[str, BehaviorFile]) -> str:
        if used in there:
            return there[used].checksum
        return BASIC if used in self.domain.behaviors else HAND_WRITTEN

    def _earlier(self, name: str, there: Mapping[str, BehaviorFile]) -> str:
        if name in there:
            return there[name].checksum
        for number in reversed(self.versions(name)):
            try:
                return self.version(name, number).checksum
            except LibraryError:
                continue
        return ""

    def _check_fit(
        self,
        there: Mapping[str, BehaviorFile],
        problems: Mapping[str, str],
        new: Mapping[str, BehaviorFile],
    ) -> None:
        """Refuse what would not fit together, so that a library never gets worse."""
        others = {name: text for name, text in problems.items() if name not in new}
        wrong = misfits({**there, **new}, self.domain, others)
        if wrong:
            names = ", ".join(f'"{name}"' for name in sorted(new))
            raise LibraryError(
                f"{names} cannot be added:\n" + "\n".join(wrong[name] for name in sorted(wrong))
            )
