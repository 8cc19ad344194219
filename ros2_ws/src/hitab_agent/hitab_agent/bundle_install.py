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
    loaded: LoadedLibrary | None = None
    note: bytes = b""
    generation: int = 0

    def refuse_all(self, error: Exception) -> None:
        self.refused |= dict.fromkeys(self.receivers, what_went_wrong(error))
        self.loaded, self.note = None, b""

    def current(self) -> LoadedLibrary:
        """Return the library as it is now, even if it was changed after the plan."""
        if self.loaded is None or self.generation != self.library.generation:
            self.loaded = self.library.loaded(strict=False)
            self.generation = self.library.generation
        return self.loaded


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
        installs: dict[BehaviorLibrary, _LibraryInstall] = {}
        for receiver in receivers:
            library = receiver.agent.library
            installs.setdefault(library, _LibraryInstall(library)).receivers.append(receiver)
        self._installs = list(installs.values())

    def job(self) -> Job:
        """Do the whole installation, in slices."""
        yield from self._read()
        yield from self._announce_all()
        yield from self._make_durable()
        for install in self._installs:
            for receiver in install.receivers:
                self._swap(install, receiver)
                yield None
        if notes := [(install.library.folder, install.note) for install in self._announced()]:
            # No agent waits until the files are written: the note counts already.
            yield in_background(partial(_carry_out, notes))

    def _read(self) -> Job:
        """Verify and learn the bundle, once per domain."""
        groups: dict[LibraryReader, list[_LibraryInstall]] = {}
        for install in self._installs:
            groups.setdefault(install.library.reader, []).append(install)
        for reader, installs in groups.items():
            reading = in_background(partial(read_bundle, self._bundle, reader))
            yield reading
            try:
                self._read_files.append(reading.result())  # kept, so that others read no file
            except Exception as error:
                for install in installs:
                    install.refuse_all(error)

    def _announce_all(self) -> Job:
        """Check each library and its agents, and announce its change to all processes."""
        waiting = deque(install for install in self._installs if not install.refused)
        deadline = time.monotonic() + LOCK_TIMEOUT_S
        while waiting:
            install = waiting.popleft()
            try:
                self._announce(install)
            except FolderInUseError as error:
                if time.monotonic() > deadline:
                    install.refuse_all(error)
                else:
                    waiting.append(install)
                    yield in_background(partial(time.sleep, _RETRY_S))
            except Exception as error:
                install.refuse_all(error)
            yield None

    def _announce(self, install: _LibraryInstall) -> None:
        library = install.library
        with library.change(patience=0.0, sync=False) as change:
            loaded = plan_bundle(change, self._bundle)
            for receiver in install.receivers:
                try:
                    receiver.agent.check_fit(loaded, self._start)
                except HitabError as error:
                    install.refused[receiver] = str(error)
            if len(install.refused) == len(install.receivers):
                return
            change.announce()
        install.loaded, install.note, install.generation = loaded, change.note, library.generation
        for receiver, why in install.refused.items():
            install.refused[receiver] = f"{why}; {_SHARED}"

    def _make_durable(self) -> Job:
        """Sync all changes to disk; withdraw those that fail."""
        folders = [install.library.folder for install in self._announced()]
        if not folders:
            return
        syncing = in_background(partial(_force_to_disk, folders))
        yield syncing
        try:
            syncing.result()
        except Exception as error:
            for install in self._announced():
                if withdraw(install.library.folder, install.note):
                    install.refuse_all(error)
                    install.library.load(strict=False)

    def _swap(self, install: _LibraryInstall, receiver: Any) -> None:
        agent = receiver.agent
        digest, why = "", install.refused.get(receiver, "")
        if not why:
            try:
                if agent.library is not install.library:
                    raise HitabError(f"{agent.name} uses another library now; send it again")
                loaded = install.current()
                notes = agent.take_up(loaded, self._start)
                digest, why = self._digest_of(loaded), "; ".join(notes)
            except Exception as error:
                why = f"{what_went_wrong(error)}; {_SAVED}"
        self._taken_in(receiver, self._sequence, digest, why)

    def _digest_of(self, loaded: LoadedLibrary) -> str:
        if loaded not in self._digests:
            names = [name for name, _ in self._bundle.files]
            self._digests[loaded] = digest_in(loaded, names)
        return self._digests[loaded]

    def _announced(self) -> list[_LibraryInstall]:
        return [install for install in self._installs if install.note]


_SHARED = "other agents with this library have the behavior; reload the library to use it here"
_SAVED = "the behavior is in the library; reload the library to use it"


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
