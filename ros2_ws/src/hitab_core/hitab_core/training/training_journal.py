"""The journal of an agent's training, from its beginning until it is saved or discarded."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from hitab_core.errors import FolderInUseError, HitabError, LibraryError, TrainingError
from hitab_core.example import Example
from hitab_core.example_codec import example_of, example_record
from hitab_core.running.run_context import RunContext
from hitab_core.training.cost import RESUMED, TrainingCost, has_steps, training_cost
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.example_journal import ExampleJournal, archive, records_in
from hitab_core.training.lateness import Lateness
from hitab_core.training.training_session import TrainingSession
from hitab_core.use import Use

JOURNAL_FILE = "training.jsonl"


class TrainingJournal:
    """Keeps the current training on disk, where it survives the process.

    Without a folder it keeps nothing.

    Attributes:
        damage: why the training on disk cannot be resumed, and the way out; empty if none is
            there, or it was resumed.
    """

    def __init__(self, folder: Path | None, domain: str) -> None:
        """Name the journal; nothing is read or written yet.

        Args:
            folder: of the journal; None to keep no journal.
            domain: name of the agent's domain.
        """
        self._path = None if folder is None else folder / JOURNAL_FILE
        self.damage = ""
        self._domain = domain
        self._file: ExampleJournal | None = None

    def begin(
        self, curriculum: Curriculum, examples: Iterable[Example], readable: Iterable[Use]
    ) -> None:
        """Begin the journal of a training, in place of the one before.

        Args:
            curriculum: what is trained.
            examples: to continue from.
            readable: names of all readings.

        Raises:
            LibraryError: if it cannot be written; then the one before is still there.
        """
        if self._path is None:
            return
        file = ExampleJournal.begin(
            self._path,
            {
                "do": "begin",
                "domain": self._domain,
                "curriculum": curriculum.to_record(),
                "examples": [example_record(e) for e in examples],
                "readable": [str(use) for use in readable],
                "at": time.time(),
            },
        )
        self.close()
        self._file, self.damage = file, ""

    def write(self, record: Mapping[str, object]) -> None:
        """Write what was done; it is on disk when this returns.

        Raises:
            LibraryError: if it cannot be written.
        """
        if self._file is not None:
            self._file.append({**record, "at": time.time()})

    def costs(self) -> list[TrainingCost]:
        """Return what the trainings on disk cost, oldest first.

        Those of which nothing is known, in which nothing was done, or whose journals are damaged,
        are left out.
        """
        if self._path is None:
            return []
        paths = self._path.parent.glob(f"{self._path.stem}*{self._path.suffix}")
        # Only the training that this process has open goes on.
        going_on = self._path if self._file is not None else None
        costs = (
            _cost_in(path, time.time() if path == going_on else None, begun=False)
            for path in paths
        )
        return sorted(filter(None, costs), key=lambda cost: cost.began)

    def unsaved(self) -> TrainingCost | None:
        """Return what the training under way has cost so far, whichever process it is in.

        None: there is none, it is saved already, or its journal is damaged.
        """
        cost = _cost_in(self._path) if self._path is not None else None
        return cost if cost is not None and not cost.finished else None

    def discard(self) -> None:
        """Archive the journal of a training that is given up.

        Raises:
            LibraryError: if it cannot be moved.
        """
        if self._file is not None:
            self._file.archive()
            self._file = None
        elif self._path is not None and self.damage:
            archive(self._path)
        self.damage = ""

    def archive(self) -> None:
        """Archive the journal of a saved training; if that fails, the next start does it."""
        file, self._file = self._file, None
        if file is not None:
            with suppress(LibraryError):
                file.archive()
            file.close()

    def close(self) -> None:
        """Close the file; it stays where it is."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def resume(
        self,
        context: RunContext,
        has_saved: Callable[[str, str], bool],
        people: dict[str, Lateness],
    ) -> TrainingSession | None:
        """Return the interrupted training; None if there is none, or `damage` says why not.

        Args:
            context: of the agent.
            has_saved: whether the library has a behavior of this name and checksum.
            people: see `TrainingSession`.

        Raises:
            FolderInUseError: if another process uses it.
        """
        self.damage = ""
        try:
            return self._resumed(context, has_saved, people)
        except FolderInUseError:
            raise
        except LibraryError as error:
            self.damage = str(error)
            return None

    def _resumed(
        self,
        context: RunContext,
        has_saved: Callable[[str, str], bool],
        people: dict[str, Lateness],
    ) -> TrainingSession | None:
        path = self._path
        if path is None or not path.exists():
            return None
        file = ExampleJournal.open(path)
        records = file.records
        if not records:
            file.discard()
            return None
        last = next((r for r in reversed(records) if r.get("do") != RESUMED), records[-1])
        if last.get("do") == "save" and has_saved(
            str(last.get("automaton")), str(last.get("checksum"))
        ):
            # The process ended after saving the behavior and before archiving the journal.
            self._file = file
            self.archive()
            return None
        try:
            session = self._replayed(records, context, people)
        except (HitabError, KeyError, TypeError, ValueError) as error:
            file.close()
            raise LibraryError(
                f"{path}: the interrupted training cannot be resumed: {error}; "
                "fix that, or move this file away to start without that training"
            ) from error
        self._file = file
        with suppress(LibraryError):  # only what the training took depends on it
            self.write({"do": RESUMED})
        return session

    def _replayed(
        self,
        records: Iterable[Mapping[str, Any]],
        context: RunContext,
        people: dict[str, Lateness],
    ) -> TrainingSession:
        begin, *rest = (record for record in records if record.get("do") != RESUMED)
        if begin["domain"] != self._domain:
            raise TrainingError(
                f'it is of domain "{begin["domain"]}", and the agent has "{self._domain}"'
            )
        curriculum = Curriculum.from_record(begin["curriculum"])
        session = TrainingSession(
            context,
            curriculum,
            map(example_of, begin["examples"]),
            self.write,
            tuple(map(Use.parse, begin["readable"])),
            people,
        )
        session.replay(rest)
        return session


def _cost_in(path: Path, now: float | None = None, *, begun: bool = True) -> TrainingCost | None:
    """Return what a training cost; None if there is none, nothing is known, or it is damaged.

    Args:
        path: of the journal.
        now: the time, if the training goes on.
        begun: whether one that was only begun counts.
    """
    records = records_in(path)
    with suppress(HitabError, KeyError, TypeError, ValueError):
        if records and (begun or has_steps(records)):
            return training_cost(records, now)
    return None
