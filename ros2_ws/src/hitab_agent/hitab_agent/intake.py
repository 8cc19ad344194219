"""Taking in what was distributed, for all agents of a process at once.

It is verified, read and learned once for each domain, written once for each library, and forced
to disk for all libraries together: a thousand folders then take as long as one. After that each
agent swaps what it knows.

A library is changed by a note that counts for everybody as soon as it is there (see
`hitab_core.library.commit`), so that nothing has to be held between two slices: whoever else
comes to a folder carries the note out.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Protocol

from hitab_agent.slices import Background, Job
from hitab_core import Agent, BehaviorLibrary, FolderInUseError, HitabError, Use
from hitab_core.library import Bundle, Edition, Editions, digest_in, plan_bundle, read_bundle
from hitab_core.library.commit import carry_out, forget, withdraw
from hitab_core.library.durable_files import PATIENCE, file_errors, sync_trees
from hitab_ros.answering import what_went_wrong

_RETRY_S = 0.01
"""How long a folder that somebody else holds is left alone."""

_BREATH_S = 0.001
"""How long a thread leaves Python's lock to the callbacks after each folder."""


class Receiver(Protocol):
    """An agent of the process, as far as it receives what is distributed."""

    agent: Agent

    def has_taken_in(self, sequence: int, digest: str, error: str) -> None:
        """Publish what came of a distribution.

        Args:
            sequence: of the distribution.
            digest: over the files as it has them now; empty if it was refused.
            error: why it was refused, or what went wrong when it was begun; empty if all is well.
        """


@dataclass(eq=False)
class _Shelf:
    """A library with the agents that have it, and what becomes of it."""

    library: BehaviorLibrary
    receivers: list[Receiver] = field(default_factory=list)
    refused: dict[Receiver, str] = field(default_factory=dict)
    edition: Edition | None = None
    note: bytes = b""
    generation: int = 0

    def refuse_all(self, error: Exception) -> None:
        self.refused |= dict.fromkeys(self.receivers, what_went_wrong(error))
        self.edition, self.note = None, b""

    def current(self) -> Edition:
        """Return what the library holds, also if somebody has changed it since it was planned."""
        if self.edition is None or self.generation != self.library.generation:
            self.edition, self.generation = self.library.edition(), self.library.generation
        return self.edition


class Intake:
    """One distribution being taken in by those agents of a process that are meant."""

    def __init__(
        self, sequence: int, bundle: Bundle, start: Use | None, receivers: Iterable[Receiver]
    ) -> None:
        """Make ready.

        Args:
            sequence: of the distribution.
            bundle: what was distributed.
            start: what the receivers are to perform then; None: what they perform now.
            receivers: who is meant.
        """
        self._sequence = sequence
        self._bundle = bundle
        self._start = start
        self._digests: dict[Edition, str] = {}
        self._read_files: list[object] = []
        shelves: dict[BehaviorLibrary, _Shelf] = {}
        for receiver in receivers:
            library = receiver.agent.library
            shelves.setdefault(library, _Shelf(library)).receivers.append(receiver)
        self._shelves = list(shelves.values())

    def job(self) -> Job:
        """Do all of it, in slices."""
        yield from self._read()
        yield from self._announce_all()
        yield from self._make_durable()
        for shelf in self._shelves:
            for receiver in shelf.receivers:
                self._swap(shelf, receiver)
                yield None
        yield from self._carry_out()

    def _read(self) -> Job:
        """Verify and learn the bundle, once for each domain."""
        groups: dict[Editions, list[_Shelf]] = {}
        for shelf in self._shelves:
            groups.setdefault(shelf.library.editions, []).append(shelf)
        for editions, shelves in groups.items():
            reading = Background(partial(read_bundle, self._bundle, editions))
            yield reading
            try:
                self._read_files.append(reading.result())  # kept, so that it is read once
            except Exception as error:
                for shelf in shelves:
                    shelf.refuse_all(error)

    def _announce_all(self) -> Job:
        """Check each library and its agents, and change it for all to see."""
        waiting = deque(shelf for shelf in self._shelves if not shelf.refused)
        deadline = time.monotonic() + PATIENCE
        while waiting:
            shelf = waiting.popleft()
            try:
                self._announce(shelf)
            except FolderInUseError as error:
                if time.monotonic() > deadline:
                    shelf.refuse_all(error)
                else:
                    waiting.append(shelf)
                    yield Background(partial(time.sleep, _RETRY_S))
            except Exception as error:
                shelf.refuse_all(error)
            yield None

    def _announce(self, shelf: _Shelf) -> None:
        library = shelf.library
        with library.change(patience=0.0, sync=False) as change:
            edition = plan_bundle(change, self._bundle, library.editions)
            for receiver in shelf.receivers:
                try:
                    receiver.agent.check_fit(edition, self._start)
                except HitabError as error:
                    shelf.refused[receiver] = str(error)
            if len(shelf.refused) == len(shelf.receivers):
                return
            change.announce()
        shelf.edition, shelf.note, shelf.generation = edition, change.note, library.generation
        for receiver, why in shelf.refused.items():
            shelf.refused[receiver] = f"{why}; {_SHARED}"

    def _make_durable(self) -> Job:
        """Have the disk take all changes; what it does not take is taken back."""
        try:
            yield from self._sync()
        except Exception as error:
            for shelf in self._noted():
                if withdraw(shelf.library.folder, shelf.note):
                    shelf.refuse_all(error)
                    shelf.library.load(strict=False)

    def _swap(self, shelf: _Shelf, receiver: Receiver) -> None:
        agent = receiver.agent
        digest, why = "", shelf.refused.get(receiver, "")
        if not why:
            try:
                if agent.library is not shelf.library:
                    raise HitabError(f"{agent.name} has another library now; send it again")
                edition = shelf.current()
                notes = agent.take_up(edition, self._start)
                digest, why = self._digest_in(edition), "; ".join(notes)
            except Exception as error:
                why = f"{what_went_wrong(error)}; {_SAVED}"
        receiver.has_taken_in(self._sequence, digest, why)

    def _digest_in(self, edition: Edition) -> str:
        if edition not in self._digests:
            names = [name for name, _ in self._bundle.files]
            self._digests[edition] = digest_in(edition, names)
        return self._digests[edition]

    def _carry_out(self) -> Job:
        """Bring the files of all libraries up to date, now that nobody waits for it."""
        notes = [(shelf.library.folder, shelf.note) for shelf in self._noted()]
        if notes:
            yield Background(partial(_carry_out, notes))

    def _sync(self) -> Job:
        folders = [shelf.library.folder for shelf in self._noted()]
        if folders:
            syncing = Background(partial(_force_to_disk, folders))
            yield syncing
            syncing.result()

    def _noted(self) -> list[_Shelf]:
        return [shelf for shelf in self._shelves if shelf.note]


_SHARED = "others that share its library have it, and it takes it up when it reloads the library"
_SAVED = "it is in its library, and is taken up when that is reloaded"


def _force_to_disk(folders: list[Path]) -> None:
    with file_errors(folders[0], "write to"):
        sync_trees(folders)


def _carry_out(notes: list[tuple[Path, bytes]]) -> None:
    """Do what notes say. They stay where the disk fails: who comes next carries them out."""
    for folder, note in notes:
        carry_out(folder, note)
        time.sleep(_BREATH_S)
    with suppress(OSError):
        sync_trees(folder for folder, _ in notes)
        for folder, note in notes:
            forget(folder, note)
            time.sleep(_BREATH_S)
