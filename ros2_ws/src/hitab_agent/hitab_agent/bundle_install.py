"""Installs a distribution for all agents of a process at once.

A distribution is verified, read and learned once per domain, written once per library, and synced
to disk for all libraries together, so that a thousand folders take as long as one. Then each agent
swaps its repertoire.

A library is changed by a note that is valid for all processes as soon as it exists (see
`hitab_core.library.commit`), so no lock is held between two slices: the next process that opens
the folder carries the note out.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from hitab_agent.scheduler import Job, in_background
from hitab_core import BehaviorLibrary, FolderInUseError, HitabError, Use
from hitab_core.library import (
    Bundle,
    LibraryReader,
    LoadedLibrary,
    digest_in,
    plan_bundle,
    read_bundle,
)
from hitab_core.library.commit import carry_out, forget, withdraw
from hitab_core.library.durable_files import LOCK_TIMEOUT_S, file_errors, sync_trees
from hitab_ros.answering import what_went_wrong

_RETRY_S = 0.01
"""How long to wait before retrying a folder that another process holds."""

_YIELD_S = 0.001
"""How long a thread releases Python's lock to the callbacks after each folder."""


TakenIn = Callable[[Any, int, str, str], None]
"""Called with an agent's node, the sequence of a distribution, the digest of the agent's files
(empty if it refused them), and the reason of the refusal or a fault of the started behavior."""


@dataclass(eq=False)
class _LibraryInstall:
    """A library with the agents that use it, and the state of its change."""

    library: BehaviorLibrary
    receivers: list[Any] = field(default_factory=list)
    refused: dict[Any, str] = field(default_factory=dict)
    edition: LoadedLibrary | None = None
    note: bytes = b""
    generation: int = 0

    def refuse_all(self, error: Exception) -> None:
        self.refused |= dict.fromkeys(self.receivers, what_went_wrong(error))
        self.edition, self.note = None, b""

    def current(self) -> LoadedLibrary:
        """Return what the library holds now, even if it was changed after the plan."""
        if self.edition is None or self.generation != self.library.generation:
            self.edition = self.library.loaded(strict=False)
            self.generation = self.library.generation
        return self.edition


class BundleInstall:
    """Installs a distribution for its receivers in a process."""

    def __init__(
        self,
        sequence: int,
        bundle: Bundle,
        start: Use | None,
        receivers: Iterable[Any],
        taken_in: TakenIn,
    ) -> None:
        """Group the receivers by library.

        Args:
            sequence: the distribution's number.
            bundle: the behaviors.
            start: the behavior to start afterwards; None to continue the present one.
            receivers: the nodes of the receiving agents.
            taken_in: called with each receiver's outcome.
        """
        self._sequence = sequence
        self._bundle = bundle
        self._start = start
        self._taken_in = taken_in
        self._digests: dict[LoadedLibrary, str] = {}
        self._read_files: list[object] = []
        shelves: dict[BehaviorLibrary, _LibraryInstall] = {}
        for receiver in receivers:
            library = receiver.agent.library
            shelves.setdefault(library, _LibraryInstall(library)).receivers.append(receiver)
        self._shelves = list(shelves.values())

    def job(self) -> Job:
        """Do the whole installation, in slices."""
        yield from self._read()
        yield from self._announce_all()
        yield from self._make_durable()
        for shelf in self._shelves:
            for receiver in shelf.receivers:
                self._swap(shelf, receiver)
                yield None
        if notes := [(shelf.library.folder, shelf.note) for shelf in self._noted()]:
            # No agent waits until the files are written: the note counts already.
            yield in_background(partial(_carry_out, notes))

    def _read(self) -> Job:
        """Verify and learn the bundle, once per domain."""
        groups: dict[LibraryReader, list[_LibraryInstall]] = {}
        for shelf in self._shelves:
            groups.setdefault(shelf.library.reader, []).append(shelf)
        for editions, shelves in groups.items():
            reading = in_background(partial(read_bundle, self._bundle, editions))
            yield reading
            try:
                self._read_files.append(reading.result())  # kept: a second receiver reads no file
            except Exception as error:
                for shelf in shelves:
                    shelf.refuse_all(error)

    def _announce_all(self) -> Job:
        """Check each library and its agents, and announce its change to all processes."""
        waiting = deque(shelf for shelf in self._shelves if not shelf.refused)
        deadline = time.monotonic() + LOCK_TIMEOUT_S
        while waiting:
            shelf = waiting.popleft()
            try:
                self._announce(shelf)
            except FolderInUseError as error:
                if time.monotonic() > deadline:
                    shelf.refuse_all(error)
                else:
                    waiting.append(shelf)
                    yield in_background(partial(time.sleep, _RETRY_S))
            except Exception as error:
                shelf.refuse_all(error)
            yield None

    def _announce(self, shelf: _LibraryInstall) -> None:
        library = shelf.library
        with library.change(patience=0.0, sync=False) as change:
            edition = plan_bundle(change, self._bundle)
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
        """Sync all changes to disk; withdraw those that fail."""
        folders = [shelf.library.folder for shelf in self._noted()]
        if not folders:
            return
        syncing = in_background(partial(_force_to_disk, folders))
        yield syncing
        try:
            syncing.result()
        except Exception as error:
            for shelf in self._noted():
                if withdraw(shelf.library.folder, shelf.note):
                    shelf.refuse_all(error)
                    shelf.library.load(strict=False)

    def _swap(self, shelf: _LibraryInstall, receiver: Any) -> None:
        agent = receiver.agent
        digest, why = "", shelf.refused.get(receiver, "")
        if not why:
            try:
                if agent.library is not shelf.library:
                    raise HitabError(f"{agent.name} uses another library now; send it again")
                edition = shelf.current()
                notes = agent.take_up(edition, self._start)
                digest, why = self._digest_in(edition), "; ".join(notes)
            except Exception as error:
                why = f"{what_went_wrong(error)}; {_SAVED}"
        self._taken_in(receiver, self._sequence, digest, why)

    def _digest_in(self, edition: LoadedLibrary) -> str:
        if edition not in self._digests:
            names = [name for name, _ in self._bundle.files]
            self._digests[edition] = digest_in(edition, names)
        return self._digests[edition]

    def _noted(self) -> list[_LibraryInstall]:
        return [shelf for shelf in self._shelves if shelf.note]


_SHARED = "other agents that share its library have it; reload the library to use it here"
_SAVED = "it is in the library; reload the library to use it"


def _force_to_disk(folders: list[Path]) -> None:
    with file_errors(folders[0], "write to"):
        sync_trees(folders)


def _carry_out(notes: list[tuple[Path, bytes]]) -> None:
    """Carry out notes; those that fail stay, for the next process that opens the folder."""
    for folder, note in notes:
        carry_out(folder, note)
        time.sleep(_YIELD_S)
    with suppress(OSError):
        sync_trees(folder for folder, _ in notes)
        for folder, note in notes:
            forget(folder, note)
            time.sleep(_YIELD_S)
