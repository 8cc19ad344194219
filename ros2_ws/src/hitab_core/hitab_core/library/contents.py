"""What a library folder holds: the behaviors that can be used, and why the others cannot."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from hitab_core.automaton import RESERVED
from hitab_core.domain import Domain
from hitab_core.library.behavior_file import BehaviorFile, file_name
from hitab_core.library.check import misfits
from hitab_core.use import NAME
from hitab_core.wording import quantity


@dataclass(frozen=True)
class Losses:
    """The behaviors of a library that cannot be used.

    Nothing stands in for a lost behavior, not even a basic behavior of its name: who asks for it
    is refused with the reason.

    Attributes:
        reasons: why, as a sentence, by name.
        faults: one per cause: what is wrong, what it is needed for, and the way out.
        ways_out: of the causes, by name.
        unread: why the folder cannot be read, so that more may be lost; empty if it can.
    """

    reasons: Mapping[str, str] = field(default_factory=dict)
    faults: tuple[str, ...] = ()
    ways_out: Mapping[str, str] = field(default_factory=dict)
    unread: str = ""

    @classmethod
    def of_unread(cls, why: str, domain: Domain) -> Losses:
        """Return the losses of a folder that cannot be read.

        Any hand-written automaton may have been trained anew there, so none can be used.
        """
        unread = f"the library cannot be read: {why}"
        return cls(dict.fromkeys(domain.automata, unread), (unread,), unread=unread)

    def __bool__(self) -> bool:
        """Return whether anything is lost."""
        return bool(self.faults)


@dataclass(frozen=True)
class Contents:
    """The behavior files of a folder, sorted by whether they can be used.

    Attributes:
        readable: files that are sound in themselves, by name.
        unreadable: what is wrong with the others, by name.
        problems: why behaviors cannot be used, by name: the unreadable ones, those that use one of
            them, and those that do not fit together. One complaint per line.
        lost: all that is lost, hand-written automata included, each with its lost parts.
    """

    readable: Mapping[str, BehaviorFile]
    unreadable: Mapping[str, str]
    problems: Mapping[str, str]
    lost: Mapping[str, list[str]]

    @classmethod
    def of(
        cls,
        readable: Mapping[str, BehaviorFile],
        unreadable: Mapping[str, str],
        domain: Domain,
        way_back: Callable[[str], str] = lambda name: "",
    ) -> Contents:
        """Sort files.

        Args:
            readable: sound in themselves, by name.
            unreadable: what is wrong with the others.
            domain: in which they were trained.
            way_back: returns how to bring back a behavior that was deleted; "": it was not.
        """
        wrong, lost = misfits(readable, domain, unreadable, way_back)
        return cls(readable, unreadable, {**unreadable, **wrong}, lost)

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

    def losses(self, folder: Path, sound_version: Callable[[str], int | None]) -> Losses:
        """Return what is lost.

        Args:
            folder: of the files.
            sound_version: returns the newest version of a behavior that can be read; None: none.
        """
        reasons: dict[str, str] = {}
        concerned: dict[str, list[str]] = {}
        for name in sorted(self.lost):
            way = [name]
            while self.lost[way[-1]]:  # what explains it, and in the end the cause
                way.append(self.lost[way[-1]][0])
            reasons[name] = self._reason(folder, way)
            others = concerned.setdefault(way[-1], [])
            if way[-1] != name:
                others.append(name)
        faults, ways_out = [], {}
        for cause, others in concerned.items():
            also = f"; it is needed for {', '.join(others)}" if others else ""
            if cause in self.unreadable:
                ways_out[cause] = way_out(cause, folder, sound_version(cause))
            else:  # its own file is sound
                ways_out[cause] = _given_up(cause, folder)
            faults.append(f"{reasons[cause]}{also}; {ways_out[cause]}")
        return Losses(reasons, tuple(faults), ways_out)

    def _reason(self, folder: Path, way: list[str]) -> str:
        """Return why the first on a way of parts cannot be used: its last is the cause."""
        first, cause = way[0], way[-1]
        lines = self.problems[cause].splitlines()
        more = f" (and {quantity(len(lines) - 1, 'more complaint')})" if len(lines) > 1 else ""
        at_line = re.sub(
            rf"^(?:.*/)?{re.escape(file_name(cause))}:(\d+): ", r"line \1: ", lines[0]
        )
        where = folder / file_name(cause)
        why = f"cannot be used: {at_line}{more}"
        if len(way) == 1:
            return f"the file of {cause}, {where}, {why}"
        between = "".join(f"{part}, which needs " for part in way[1:-1])
        return f"{first} needs {between}{cause}, whose file {where} {why}"


def way_out(name: str, folder: Path, sound_version: int | None) -> str:
    """Return what a person can do about a lost behavior."""
    if NAME.match(name) is None or name in RESERVED:
        return f"move {file_name(name)} out of the folder"
    if sound_version is None:
        return (
            f"have an agent that has it send it with `hitab distribute AGENT {name}`; put an "
            f"intact file in its place; {_given_up(name, folder)}"
        )
    return f"{brought_back(name, folder, sound_version)}; {_given_up(name, folder)}"


def brought_back(name: str, folder: Path, version: int) -> str:
    """Return how to bring a version of a behavior back."""
    at = shlex.quote(str(folder))
    return f"bring version {version} back with `hitab library restore {name} {version} -l {at}`"


def _given_up(name: str, folder: Path) -> str:
    at = shlex.quote(str(folder))
    return f"or give it up with `hitab library delete {name} -l {at}`"
