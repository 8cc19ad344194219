"""Contents of a library folder: usable behaviors, and why the others are lost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hitab_core.automaton import RESERVED_NAMES
from hitab_core.domain import Domain
from hitab_core.library.behavior_file import BehaviorFile, file_name
from hitab_core.term import VOCABULARY_NAME
from hitab_core.texts.errors import LibraryError
from hitab_core.texts.remedies import Fix, Remedy
from hitab_core.texts.wording import quantity


@dataclass(frozen=True)
class LostBehaviors:
    """The behaviors of a library that cannot be used.

    Nothing replaces a lost behavior, not even a basic behavior of its name: a request for it
    raises an error with the reason.

    Attributes:
        reasons: reason of each loss, as a sentence, by name.
        faults: one per cause: the fault, and the behaviors that need the lost one.
        remedies: remedies of the cause, by name.
        unread: why the folder cannot be read, so that more may be lost; empty if it can.
    """

    reasons: Mapping[str, str] = field(default_factory=dict)
    faults: tuple[str, ...] = ()
    remedies: Mapping[str, tuple[Remedy, ...]] = field(default_factory=dict)
    unread: str = ""

    @classmethod
    def of_unread(cls, why: str, domain: Domain) -> LostBehaviors:
        """Return the losses of a folder that cannot be read.

        Any hand-written automaton may have been trained anew there, so none can be used.
        """
        unread = f"the library cannot be read: {why}"
        return cls(dict.fromkeys(domain.automata, unread), (unread,), unread=unread)

    def __bool__(self) -> bool:
        """Return whether anything is lost."""
        return bool(self.faults)

    @property
    def ways_out(self) -> tuple[Remedy, ...]:
        """Remedies for the only cause; for several causes, a list of them."""
        if len(self.faults) == 1 and self.remedies:
            return next(iter(self.remedies.values()))
        return (Fix.CHECK_LIBRARY(),) * bool(self)


@dataclass(frozen=True)
class LibraryContents:
    """The behavior files of a folder, sorted by whether they can be used.

    Attributes:
        readable: files that are sound in themselves, by name.
        unreadable: faults of the other files, by name.
        problems: faults of unusable behaviors, by name: of unreadable ones, of behaviors that use
            one of them, and of behaviors that do not fit together. One complaint per line.
        lost: all that is lost, hand-written automata included, each with its lost parts.
    """

    readable: Mapping[str, BehaviorFile]
    unreadable: Mapping[str, LibraryError]
    problems: Mapping[str, str]
    lost: Mapping[str, list[str]]

    @property
    def usable(self) -> dict[str, BehaviorFile]:
        """The files of the behaviors that can be used, by name."""
        return {name: f for name, f in self.readable.items() if name not in self.problems}

    def users(self, name: str) -> list[str]:
        """Return the names of the behaviors that use one directly, sorted."""
        files = self.readable
        return sorted(n for n in files if name in files[n].automaton.behaviors_used)

    def all_users(self, name: str) -> set[str]:
        """Return the names of the behaviors that use one, also by way of others."""
        found: set[str] = set()
        waiting = [name]
        while waiting:
            more = {*self.users(waiting.pop())} - found
            found |= more
            waiting += more
        return found - {name}

    def losses(self, folder: Path, sound_version: Callable[[str], int | None]) -> LostBehaviors:
        """Return the lost behaviors.

        Args:
            folder: folder of the files.
            sound_version: returns the newest readable version of a behavior, or None.
        """
        reasons: dict[str, str] = {}
        remedies: dict[str, tuple[Remedy, ...]] = {}
        concerned: dict[str, list[str]] = {}
        for name in sorted(self.lost):
            way = [name]
            while self.lost[way[-1]]:  # down to the cause
                way.append(self.lost[way[-1]][0])
            cause = way[-1]
            reasons[name] = self._reason(folder, way)
            others = concerned.setdefault(cause, [])
            if cause != name:
                others.append(name)
            if cause not in remedies:
                remedies[cause] = self._remedies(cause, folder, sound_version)
            remedies[name] = remedies[cause]
        faults = tuple(
            f"{reasons[cause]}; it is needed for {', '.join(others)}" if others else reasons[cause]
            for cause, others in concerned.items()
        )
        return LostBehaviors(reasons, faults, remedies)

    def _remedies(
        self, cause: str, folder: Path, sound_version: Callable[[str], int | None]
    ) -> tuple[Remedy, ...]:
        """Return the remedies for a lost behavior that is itself a cause."""
        file = folder / file_name(cause)
        if VOCABULARY_NAME.match(cause) is None or cause in RESERVED_NAMES:
            return (Fix.MOVE_AWAY(file=file),)
        gone = frozenset({cause})
        if cause in self.readable:  # its own file is sound; perhaps a part was deleted
            gone = self.readable[cause].automaton.behaviors_used - self.readable.keys()
        restored = [
            Fix.RESTORE(behavior=name, version=version, folder=folder)
            for name in sorted(gone)
            if (version := sound_version(name)) is not None
        ]
        others = [Fix.SEND(behavior=cause), Fix.PUT_INTACT(file=file)] if cause in gone else []
        given_up = Fix.DELETE(behavior=cause, folder=folder)
        return (*(restored or others), given_up)

    def _reason(self, folder: Path, way: list[str]) -> str:
        """Return why the first on a way of parts cannot be used: its last is the cause."""
        first, cause = way[0], way[-1]
        first_line, *more = self.problems[cause].splitlines()
        also = f" (and {quantity(len(more), 'more complaint')})" if more else ""
        why = f"its file in {folder} cannot be used: {first_line}{also}"
        between = "".join(f"{part}, which needs " for part in way[1:-1])
        lost = f"{first} is lost" if first == cause else f"{first} needs {between}{cause}"
        return f"{lost}: {why}"
