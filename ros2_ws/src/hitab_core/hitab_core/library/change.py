"""One change to a library: planned, checked, then made as a whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from hitab_core.automaton import Automaton
from hitab_core.library.behavior_file import BASIC, HAND_WRITTEN, BehaviorFile, text_of
from hitab_core.library.commit import Changes, commit
from hitab_core.library.contents import LibraryContents, LostBehaviors
from hitab_core.library.expectation import Expectation, broken_expectations
from hitab_core.library.library_files import LibraryFiles
from hitab_core.library.loaded_library import LoadedLibrary
from hitab_core.library.provenance import Provenance, tool_name
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.vocabulary import has
from hitab_core.texts.wording import quantity


class LibraryChange:
    """A change being planned while the library is locked.

    Get one from `BehaviorLibrary.change`. Plan with `save`, `install` or `remove`, inspect
    `contents`, then `commit` or drop it. Nothing is written before the commit.

    Attributes:
        before, contents: contents of the library before and after the change.
        changed: the planned files, by name; None for a removed file.
        numbers: version numbers of the planned files, by name.
    """

    def __init__(
        self,
        on_disk: LibraryFiles,
        clock: Callable[[], str],
        done: Callable[[LibraryChange], None],
    ) -> None:
        """Start planning.

        Args:
            on_disk: files of the library, locked exclusively while this is used.
            clock: returns the time, ISO 8601, to record in saved files.
            done: called once the change is made.
        """
        self.before = self.contents = on_disk.contents()
        self.changed: dict[str, BehaviorFile | None] = {}
        self.numbers: dict[str, int] = {}
        self._on_disk = on_disk
        self._reader = on_disk.reader
        self._domain = on_disk.reader.domain
        self._clock = clock
        self._done = done
        self._changes: dict[str, bytes | None] = {}

    @property
    def losses(self) -> LostBehaviors:
        """The behaviors that cannot be used after the change."""
        return self._on_disk.losses(self.contents)

    def loaded(self) -> LoadedLibrary:
        """Return the loaded library after the change.

        Raises:
            VocabularyError: if its behaviors do not fit the domain.
        """
        return self._on_disk.loaded(self.contents)

    # -- planning ---------------------------------------------------------------------------

    def save(
        self,
        automaton: Automaton,
        classifier: str,
        provenance: Provenance,
        *,
        restored: bool = False,
        expectations: Sequence[Expectation] | None = None,
    ) -> BehaviorFile:
        """Plan to add a behavior, or a new version of it; return its file.

        Args:
            automaton: the automaton to save.
            classifier: classifier that learned it.
            provenance: origin of the automaton.
            restored: whether a person brings an earlier version back.
            expectations: expectations to store; None to keep the present ones.

        Raises:
            LibraryError: if it does not fit the library, breaks an expectation that blocks, or the
                behavior of its name is lost: only a person replaces that.
        """
        name = automaton.name
        path = self._on_disk.file(name)
        if not restored and name in self.contents.problems:
            losses = self.losses
            raise LibraryError(refused_name(name, "saved", losses), *losses.remedies[name])
        if expectations is None:
            there = self.contents.readable.get(name)
            expectations = () if there is None else there.expectations
        blocking = [one for one in expectations if one.blocks]
        if wrong := broken_expectations(blocking, automaton):
            raise LibraryError(
                f'"{name}" cannot be saved: {"; ".join(wrong)}; correct it, or take back what is '
                "expected"
            )
        number = self._on_disk.next_number(name, self._stated(name))
        text = text_of(
            automaton,
            self._domain,
            classifier=classifier,
            uses={used: self._as_it_is(used) for used in automaton.behaviors_used},
            provenance=replace(
                provenance,
                version=number,
                created=self._clock(),
                tool=tool_name(),
                earlier=self.contents.usable[name].checksum if self._stated(name) else "",
            ),
            expectations=expectations,
        )
        try:
            new = self._reader.read(text, path.name)
        except LibraryError as error:
            raise LibraryError(f'"{name}" cannot be saved:\n{error}') from None
        if new.edits:
            raise LibraryError("\n".join((f'"{name}" cannot be saved:', *new.edits)))
        self._check_fit({name: new})
        self._plan_additions({name: new})
        return new

    def install(self, texts: Mapping[str, str]) -> list[str]:
        """Plan to copy files of another library into this one unchanged.

        Returns:
            The names of the behaviors that will change, sorted.

        Raises:
            LibraryError: naming the faults.
        """
        new = {
            name: self._reader.read(text, self._on_disk.file(name).name)
            for name, text in texts.items()
        }
        self._check_fit(new)
        # Compare texts, comments included, as senders and receivers do.
        there = self.contents.readable
        changed = sorted(n for n in new if n not in there or there[n].text != new[n].text)
        self._plan_additions({name: new[name] for name in changed})
        return changed

    def remove(self, name: str, *, anyway: bool = False) -> list[str]:
        """Plan to remove a behavior; its versions stay.

        Args:
            name: name of the behavior, which may be lost.
            anyway: remove it even if others can no longer be used then.

        Returns:
            The names of the behaviors that cannot be used without it.

        Raises:
            LibraryError: if it is missing, or other behaviors use it.
        """
        names = self._on_disk.names()
        if name not in names:
            raise LibraryError(
                f'{self._on_disk.path}: has no behavior "{name}" {has(names, name)}'
            )
        before = self.contents.problems
        self._plan(self._on_disk.removal(name, self._stated(name)), {name: None})
        broken = sorted(self.contents.problems.keys() - before.keys())
        if broken and not anyway:
            raise LibraryError(
                f'{self._on_disk.path}: "{name}" cannot be deleted: {", ".join(broken)} could no '
                "longer be used; delete these first"
            )
        return sorted(self.contents.problems.keys() & self.contents.all_users(name))

    def replaced(self, name: str) -> str:
        """Return the number of a planned version and the replaced version; "" if none.

        Such as ``version 7, replaces version 6 (12 examples)``.
        """
        what = self.before_it(name)
        return f"version {self.numbers[name]}, replaces {what}" if what else ""

    def before_it(self, name: str) -> str:
        """Return the version that a planned one replaces, such as ``version 6 (12 examples)``.

        Empty if there is none.
        """
        former = self.numbers[name] - 1
        if name in self.before.unreadable:
            return f"a damaged file, kept as version {former}"
        if name not in self.before.readable:
            return ""
        examples = len(self.before.readable[name].automaton.examples)
        return f"version {former} ({quantity(examples, 'example')})"

    # -- making it --------------------------------------------------------------------------

    def commit(self) -> None:
        """Make the change; when this returns, it is on disk.

        Raises:
            LibraryError: if it cannot be written; nothing has changed.
        """
        commit(self._on_disk.path, self._changes)
        self._done(self)

    # -- inside -----------------------------------------------------------------------------

    def _plan(self, changes: Changes, files: Mapping[str, BehaviorFile | None]) -> None:
        self._changes |= changes
        self.changed |= files
        self.contents = self._with(files)

    def _with(self, files: Mapping[str, BehaviorFile | None]) -> LibraryContents:
        """Return the contents with some files changed."""
        now = self.contents
        readable = {name: file for name, file in now.readable.items() if name not in files}
        readable |= {name: file for name, file in files.items() if file is not None}
        unreadable = {name: text for name, text in now.unreadable.items() if name not in files}
        return self._on_disk.contents_of(readable, unreadable)

    def _plan_additions(self, files: Mapping[str, BehaviorFile]) -> None:
        changes: Changes = {}
        for name, file in files.items():
            self.numbers[name], change = self._on_disk.addition(
                name, file.text, self._stated(name)
            )
            changes |= change
        self._plan(changes, files)

    def _stated(self, name: str) -> int:
        """Return the version number in the file of a behavior; 0 if it cannot be used."""
        there = self.contents.usable.get(name)
        return 0 if there is None else there.provenance.version

    def _as_it_is(self, used: str) -> str:
        if used in self.contents.usable:
            return self.contents.usable[used].checksum
        return BASIC if used in self._domain.behaviors else HAND_WRITTEN

    def _check_fit(self, new: Mapping[str, BehaviorFile]) -> None:
        """Refuse files that do not fit together, so that a library never gets worse."""
        problems = self._with(new).problems
        wrong = [name for name in problems if name in new or name not in self.contents.problems]
        if wrong:
            names = ", ".join(f'"{name}"' for name in sorted(new))
            raise LibraryError(
                f"{names} cannot be added:\n" + "\n".join(problems[name] for name in sorted(wrong))
            )


def refused_name(name: str, done: str, losses: LostBehaviors) -> str:
    """Return why the name of a lost behavior is not given to another.

    Args:
        name: name of the lost behavior.
        done: the refused operation, such as "saved".
        losses: the behaviors that cannot be used.
    """
    return (
        f'"{name}" cannot be {done}: it would take the place of a lost behavior, so give it '
        f"another name ({losses.reasons[name]})"
    )
