"""One change to a library: planned, checked, then made as a whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from hitab_core.automaton import Automaton
from hitab_core.errors import LibraryError
from hitab_core.library.behavior_file import BASIC, HAND_WRITTEN, BehaviorFile, file_name, text_of
from hitab_core.library.behavior_reader import read_behavior
from hitab_core.library.check import misfits
from hitab_core.library.edition import Editions
from hitab_core.library.folder import Changes, LibraryFolder
from hitab_core.library.provenance import Provenance, tool_name
from hitab_core.vocabulary import has


class LibraryChange:
    """A change being planned while the library is locked.

    Get one from `BehaviorLibrary.change`. Plan with `save`, `install` or `remove`, inspect
    `after`, then `commit` or drop it. Nothing is written before the commit.

    Attributes:
        after: the usable files after the change, by name.
        problems: with other files, by name.
    """

    def __init__(
        self,
        folder: LibraryFolder,
        editions: Editions,
        there: Mapping[str, BehaviorFile],
        problems: Mapping[str, str],
        clock: Callable[[], str],
        done: Callable[[LibraryChange], None],
    ) -> None:
        """Start planning.

        Args:
            folder: locked exclusively as long as this is used.
            editions: reads behavior files, of one domain.
            there: the usable files, by name.
            problems: with the other files.
            clock: returns the time, ISO 8601, to record in saved files.
            done: called once the change is made.
        """
        self.after = dict(there)
        self.problems = dict(problems)
        self.note = b""
        self.changed: dict[str, BehaviorFile | None] = {}
        self._folder = folder
        self._editions = editions
        self._domain = editions.domain
        self._clock = clock
        self._done = done
        self._changes: dict[str, bytes | None] = {}

    # -- planning ---------------------------------------------------------------------------

    def save(
        self,
        automaton: Automaton,
        classifier: str,
        provenance: Provenance,
        *,
        edited: bool = False,
    ) -> BehaviorFile:
        """Plan to add a behavior, or a new version of it; return its file.

        Raises:
            LibraryError: if it does not fit the library.
        """
        name = automaton.name
        path = self._folder.file(name)
        # An edited file becomes the new version itself, so do not keep it as an earlier one.
        kept = {} if edited else self._unkept(name)
        number = self._folder.next_number(name, kept)
        text = text_of(
            automaton,
            self._domain,
            classifier=classifier,
            uses={used: self._as_it_is(used) for used in automaton.behaviors_used},
            provenance=replace(
                provenance,
                version=max(number, provenance.version + 1) if edited else number,
                created=self._clock(),
                tool=tool_name(),
                earlier=self._earlier(name),
            ),
        )
        try:
            new = self._editions.read(text, path.name)
        except LibraryError as error:
            raise LibraryError(f'"{name}" cannot be saved:\n{error}') from None
        self._check_fit({name: new})
        addition = self._folder.addition(name, new.provenance.version, text)
        self._plan({**kept, **addition}, {name: new})
        return new

    def install(self, texts: Mapping[str, str]) -> list[str]:
        """Plan to copy files of another library into this one unchanged.

        Returns:
            The names of the behaviors that will change, sorted.

        Raises:
            LibraryError: naming what is wrong.
        """
        new = {
            name: self._editions.read(text, self._folder.file(name).name)
            for name, text in texts.items()
        }
        self._check_fit(new)
        # Compare texts, comments included, as senders and receivers do.
        changed = sorted(
            name
            for name in new
            if name not in self.after or self.after[name].text != new[name].text
        )
        changes: dict[str, bytes | None] = {}
        for name in changed:
            changes |= self._unkept(name)
            number = self._folder.next_number(name, changes)
            changes |= self._folder.addition(name, number, texts[name])
        self._plan(changes, new)
        return changed

    def remove(self, name: str) -> None:
        """Plan to remove a behavior; its versions stay.

        Raises:
            LibraryError: if it is missing, or other behaviors use it.
        """
        names = self._folder.names()
        if name not in names:
            raise LibraryError(f'{self._folder.path}: has no behavior "{name}" {has(names, name)}')
        users = sorted(n for n, f in self.after.items() if name in f.automaton.behaviors_used)
        if users and name not in self._domain.automata:
            raise LibraryError(
                f'{self._folder.path}: "{name}" cannot be removed: it is used by '
                f"{', '.join(users)}; remove its users first"
            )
        self._plan({**self._unkept(name), file_name(name): None}, {name: None})

    def version(self, name: str, number: int) -> BehaviorFile:
        """Return one version of a behavior.

        Raises:
            LibraryError: if it is missing or faulty.
        """
        return read_version(self._folder, self._editions, name, number)

    # -- making it --------------------------------------------------------------------------

    def commit(self) -> None:
        """Make the change; when this returns, it is on disk.

        Raises:
            LibraryError: if it cannot be written; nothing has changed.
        """
        self._folder.change(self._changes)
        self._done(self)

    def announce(self) -> None:
        """Write only the note of the change; the caller syncs the disk and carries it out.

        `note` then identifies the change to `hitab_core.library.commit`; empty if nothing changes.

        Raises:
            LibraryError: if it cannot be written; nothing has changed.
        """
        if self._changes:
            self.note = self._folder.announce(self._changes)
        self._done(self)

    # -- inside -----------------------------------------------------------------------------

    def _plan(self, changes: Changes, files: Mapping[str, BehaviorFile | None]) -> None:
        self._changes |= changes
        for name, file in files.items():
            self.changed[name] = file
            self.problems.pop(name, None)
            if file is None:
                self.after.pop(name, None)
            else:
                self.after[name] = file

    def _unkept(self, name: str) -> Changes:
        there = self.after.get(name)
        return self._folder.unkept(name, 0 if there is None else there.provenance.version)

    def _as_it_is(self, used: str) -> str:
        if used in self.after:
            return self.after[used].checksum
        return BASIC if used in self._domain.behaviors else HAND_WRITTEN

    def _earlier(self, name: str) -> str:
        if name in self.after:
            return self.after[name].checksum
        for number in reversed(self._folder.versions(name)):
            try:
                return self.version(name, number).checksum
            except LibraryError:
                continue
        return ""

    def _check_fit(self, new: Mapping[str, BehaviorFile]) -> None:
        """Refuse files that do not fit together, so that a library never gets worse."""
        others = {name: text for name, text in self.problems.items() if name not in new}
        together = {**self.after, **new}
        if not others and self._editions.knows(together):
            return
        wrong = misfits(together, self._domain, others)
        if wrong:
            names = ", ".join(f'"{name}"' for name in sorted(new))
            raise LibraryError(
                f"{names} cannot be added:\n" + "\n".join(wrong[name] for name in sorted(wrong))
            )


def read_version(
    folder: LibraryFolder, editions: Editions, name: str, number: int
) -> BehaviorFile:
    """Return one version of a behavior in a folder.

    Raises:
        LibraryError: if it is missing or faulty.
    """
    versions = folder.versions(name)
    if number not in versions:
        raise LibraryError(f'{folder.path}: has no version {number} of "{name}" {has(versions)}')
    path = folder.version_file(name, number)
    return read_behavior(folder.text(path), f"{name}/{path.name}", editions.domain, name=name)
