"""The journal of an agent's trainings, each from its beginning until it is saved or discarded."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from hitab_core.codec import to_dict
from hitab_core.example import Example
from hitab_core.term import Term
from hitab_core.texts.errors import FolderInUseError, HitabError, LibraryError, TrainingError
from hitab_core.training.agent_database import MOVE_AWAY, OLDER, AgentDatabase
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.operation import Operation

if TYPE_CHECKING:
    import sqlite3

RESUMED = "resume"
"""Journal entry for the moment at which another process resumes a training."""

DISCARDED = "discard_training"
SAVED = "save_behavior"

Record = Mapping[str, Any]

T = TypeVar("T")

_CURRENT = "(SELECT max(id) FROM training WHERE waits = '')"
_END = f"UPDATE training SET waits = NULL WHERE id = {_CURRENT}"


class TrainingJournal:
    """Keeps trainings and data about demonstrators on disk, where they survive the process.

    Without a folder it keeps nothing.

    Attributes:
        people: texts about demonstrators, by name; on disk once a training ends.
        under_way: number of the training that this process keeps in it; 0 if none.
        done: ids of the operations on disk that a process before this one has done.
        recorded: whether the last operation has written what cannot be refused any more.
        damage: why the training on disk cannot be resumed, and the way out; empty if none is
            there, or it was resumed.
    """

    def __init__(self, folder: Path | None, domain: str = "") -> None:
        """Name the database; nothing is read or written yet.

        Args:
            folder: folder of the agent's database; None to keep no journal.
            domain: name of the agent's domain, to begin or resume trainings.
        """
        self._database = None if folder is None else AgentDatabase(folder)
        self.people: dict[str, str] = {}
        self.under_way = self._written = 0  # with how many records
        self.damage = ""
        self.done: list[str] = []
        self.recorded = False
        self._domain = domain
        self._operation: Operation | None = None

    @contextmanager
    def recording(self, operation: Operation) -> Iterator[None]:
        """Add the id and the person of an operation to the records that are written meanwhile."""
        self._operation, self.recorded = operation, False
        try:
            yield
        finally:
            self._operation = None

    def _completed(self, record: Record) -> Record:
        """Return a record with the operation that it belongs to, and the time."""
        of = self._operation
        done_by = {} if of is None or not of.id else {"id": of.id, "by": of.by}
        return {**record, **done_by, "at": time.time()}

    def begin(
        self, curriculum: Curriculum, examples: Iterable[Example], readable: Iterable[Term]
    ) -> None:
        """Begin the journal of a training, which replaces the previous one.

        Args:
            curriculum: the automaton in training.
            examples: examples to continue from.
            readable: names of all readings.

        Raises:
            LibraryError: if it cannot be written; then the previous one is kept.
        """
        if self._database is None:
            return
        first = {
            "do": "begin_training",
            "domain": self._domain,
            "curriculum": to_dict(curriculum),
            "examples": list(map(to_dict, examples)),
            "readable": [str(term) for term in readable],
        }
        if self.damage:
            self._database.put_aside_if_damaged()
        with self._database.transaction(keep=True) as tables:
            tables.execute(_END)
            training = tables.execute("INSERT INTO training (waits) VALUES ('')").lastrowid
            assert training is not None
            self._database.append(tables, training, 1, self._completed(first))
        self.under_way, self._written, self.damage = training, 1, ""
        self.recorded = True

    def write(self, record: Mapping[str, object]) -> None:
        """Write a step; it is on disk when this returns.

        Raises:
            LibraryError: if it cannot be written.
        """
        if self._database is not None and self.under_way:
            record = self._completed(record)
            with self._database.transaction(keep=True) as tables:
                self._database.append(tables, self.under_way, self._written + 1, record)
            self._written += 1
        self.recorded = record["do"] != SAVED  # the library may still refuse it

    def kept(self) -> list[tuple[int, list[dict[str, Any]]]]:
        """Return the trainings on disk, each with its records; damaged ones are left out."""
        return self._kept("")

    def to_resume(self) -> list[dict[str, Any]]:
        """Return the records of the training that the next start resumes; none if damaged."""
        return next((records for _, records in self._kept(f"WHERE id = {_CURRENT}")), [])

    def _kept(self, which: str) -> list[tuple[int, list[dict[str, Any]]]]:
        kept = []
        if self._database is not None and self._database.path.exists():
            with suppress(LibraryError), self._database.transaction() as tables:
                for (training,) in tables.execute(f"SELECT id FROM training {which}").fetchall():
                    with suppress(LibraryError):
                        kept.append((training, self._database.records(tables, training)))
        return kept

    def waiting(self) -> list[str]:
        """Return the libraries that trainings wait for; see `wait`."""
        if self._database is not None and self._database.path.exists():
            # They change only before agents start, so how the file was last closed is right.
            with suppress(LibraryError), self._database.as_closed() as tables:
                rows = tables.execute("SELECT waits FROM training WHERE waits > '' ORDER BY id")
                return [library for (library,) in rows]
        return []

    def wait(self, library: str, instead_of: str = "") -> None:
        """Mark a training as waiting for its library, while the agent uses another.

        Args:
            library: the library's folder; empty to resume the training at the next start.
            instead_of: the library that the training has been waiting for.

        Raises:
            LibraryError: if that cannot be written.
        """
        if self._database is not None and self._database.path.exists():
            with self._database.transaction() as tables:
                tables.execute(
                    "UPDATE training SET waits = ? WHERE waits = ?", (library, instead_of)
                )

    def discard(self) -> None:
        """End a training that is given up; its records are kept.

        Raises:
            LibraryError: if that cannot be written.
        """
        if self._database is not None and (self.under_way or self.damage):
            if self.damage:
                self._database.put_aside_if_damaged()
            self._end(self._database, {"do": DISCARDED})
        self.damage = ""

    def archive(self) -> None:
        """End a saved training; if that fails, the next start does it."""
        if self._database is not None and self.under_way:
            with suppress(LibraryError):
                self._end(self._database)
        self.close()

    def _end(self, database: AgentDatabase, *last: Record) -> None:
        with database.transaction() as tables:
            if self.under_way:
                for record in map(self._completed, last):
                    database.append(tables, self.under_way, self._written + 1, record)
            tables.execute(_END)
            tables.executemany("REPLACE INTO person VALUES (?, ?)", self.people.items())
        self.close()

    def close(self) -> None:
        """Close the database; a training under way stays there."""
        self.under_way = 0
        if self._database is not None:
            self._database.close()

    def resume(
        self, replay: Callable[[Sequence[Record]], T], has_saved: Callable[[str, str], bool]
    ) -> T | None:
        """Return the interrupted training; None if there is none, or if `damage` is set.

        Args:
            replay: function that restores a training from its records.
            has_saved: whether the library has a behavior of this name and checksum.

        Raises:
            FolderInUseError: if another process uses it.
        """
        self.damage = ""
        database = self._database
        if database is None:
            return None
        text = database.path.with_name("training.jsonl")
        if not database.path.exists():
            if text.exists():
                self.damage = f"{text}: {OLDER}"
            return None
        resumed = None
        try:
            if database.is_closed:  # most agents have no training under way, which is soon seen
                with database.as_closed() as tables:
                    if self._read(tables) is None:
                        return None
            with database.transaction(keep=True) as tables:
                training = self._read(tables)
                if training is not None:
                    records = database.records(tables, training)
                    resumed = self._replayed(records, replay, has_saved)
                    if resumed is None:
                        tables.execute(_END)
        except FolderInUseError:
            raise
        except LibraryError as error:
            self.damage = str(error)
        except (HitabError, LookupError, TypeError, ValueError) as error:
            self.damage = (
                f"{database.path}: the interrupted training cannot be resumed: {error}; fix that, "
                f"or {MOVE_AWAY}"
            )
        if resumed is None:
            self.close()
            return None
        self.under_way, self._written = training or 0, len(records)
        with suppress(LibraryError):  # only the cost of the training depends on it
            self.write({"do": RESUMED})
        return resumed

    def _read(self, tables: sqlite3.Connection) -> int | None:
        """Return the training to resume, and read the data about demonstrators."""
        if tables.execute("PRAGMA schema_version").fetchone() == (0,):
            return None  # the process was killed before it had made the tables
        self.people.update(tables.execute("SELECT name, lateness FROM person"))
        last = tables.execute("SELECT text FROM record ORDER BY key DESC LIMIT 1").fetchone()
        self.done = _ids(map(json.loads, last or ()))
        training: int | None
        (training,) = tables.execute(f"SELECT {_CURRENT}").fetchone()
        return training

    def _replayed(
        self,
        records: Sequence[Record],
        replay: Callable[[Sequence[Record]], T],
        has_saved: Callable[[str, str], bool],
    ) -> T | None:
        """Return the training that its records describe; None if it was saved."""
        records = [record for record in records if record.get("do") != RESUMED]
        begin, last = records[0], records[-1]
        if last["do"] == SAVED and has_saved(str(last["automaton"]), str(last["checksum"])):
            # The process was killed after saving the behavior and before ending the training.
            return None
        if begin["domain"] != self._domain:
            raise TrainingError(
                f'it is of domain "{begin["domain"]}", and the agent has "{self._domain}"'
            )
        # A save in the journal may have been interrupted before it was in the library.
        self.done = _ids(record for record in records if record["do"] != SAVED)
        return replay(records)


def _ids(records: Iterable[Record]) -> list[str]:
    """Return the ids of the operations in records."""
    return [str(record["id"]) for record in records if "id" in record]
