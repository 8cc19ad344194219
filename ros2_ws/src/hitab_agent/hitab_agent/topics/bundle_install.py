"""Installs a distribution for all agents of a process at once.

It is verified, read and learned once per domain, and written once per library. Then each agent
swaps its repertoire. A library is read and written in another thread, which holds its lock, so
that no callback waits for the disk or for another process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from hitab_agent.scheduler import Job, in_background
from hitab_core import BehaviorLibrary, HitabError, Term
from hitab_core.library import (
    Bundle,
    LibraryReader,
    LoadedLibrary,
    digest_in,
    plan_bundle,
    read_bundle,
)
from hitab_ros.answering import what_went_wrong

TakenIn = Callable[[Any, int, str, str], None]
"""Called with an agent's node, the sequence of a distribution, the digest of the agent's files as
they are now, empty if it was refused, and why it was refused or what went wrong at the start."""


@dataclass(eq=False)
class _LibraryInstall:
    """A library with the agents that use it, and the state of its change."""

    library: BehaviorLibrary
    receivers: list[Any] = field(default_factory=list)
    refused: dict[Any, str] = field(default_factory=dict)
    loaded: LoadedLibrary | None = None
    generation: int = 0

    def refuse_all(self, error: Exception) -> None:
        self.refused |= dict.fromkeys(self.receivers, what_went_wrong(error))

    def current(self) -> LoadedLibrary:
        """Return what the library holds now, even if it was changed after the plan."""
        if self.loaded is None or self.generation != self.library.generation:
            self.loaded = self.library.loaded(strict=False)
            self.generation = self.library.generation
        return self.loaded

    def plan(self, bundle: Bundle, *, write: bool) -> LoadedLibrary:
        """Return the library with the bundle, after writing it if wanted."""
        with self.library.change() as change:
            self.loaded = plan_bundle(change, bundle)
            if write:
                change.commit()
            self.generation = self.library.generation
        return self.loaded


class BundleInstall:
    """The installation of a distribution by its receivers in a process."""

    def __init__(
        self,
        sequence: int,
        bundle: Bundle,
        start: Term | None,
        receivers: Iterable[Any],
        taken_in: TakenIn,
    ) -> None:
        """Group the receivers by library.

        Args:
            sequence: of the distribution.
            bundle: the behaviors.
            start: behavior of the receivers afterwards; None for their present one.
            receivers: the nodes of the agents that take it in.
            taken_in: called with the outcome for each.
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
        """Do the whole intake, in slices."""
        yield from self._read()
        for install in self._installs:
            if not install.refused:
                yield from self._write(install)
        for install in self._installs:
            for receiver in install.receivers:
                self._swap(install, receiver)
                yield None

    def _read(self) -> Job:
        """Verify and learn the bundle, once per domain."""
        groups: dict[LibraryReader, list[_LibraryInstall]] = {}
        for install in self._installs:
            groups.setdefault(install.library.reader, []).append(install)
        for reader, installs in groups.items():
            reading = in_background(partial(read_bundle, self._bundle, reader))
            yield reading
            try:
                self._read_files.append(reading.result())  # kept: a second receiver reads no file
            except Exception as error:
                for install in installs:
                    install.refuse_all(error)

    def _write(self, install: _LibraryInstall) -> Job:
        """Write the bundle to a library, unless none of its agents can take it in."""
        try:
            planning = in_background(partial(install.plan, self._bundle, write=False))
            yield planning
            loaded = planning.result()
            for receiver in install.receivers:
                try:
                    receiver.agent.check_fit(loaded, self._start)
                except HitabError as error:
                    install.refused[receiver] = str(error)
            if len(install.refused) < len(install.receivers):
                writing = in_background(partial(install.plan, self._bundle, write=True))
                yield writing
                writing.result()
                for receiver, why in install.refused.items():
                    install.refused[receiver] = f"{why}; {_SHARED}"
        except Exception as error:
            install.refuse_all(error)

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


_SHARED = "other agents that share its library have it; reload the library to use it here"
_SAVED = "it is in the library; reload the library to use it"
