"""The journal of an agent's trainings, each from its beginning until it is saved or discarded."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from hitab_core.errors import FolderInUseError, HitabError, LibraryError, TrainingError
from hitab_core.example import Example
from hitab_core.example_codec import example_of, example_record
from hitab_core.running.running_automaton import RunContext
from hitab_core.training.agent_database import MOVE_AWAY, AgentDatabase
from hitab_core.training.cost import RESUMED, TrainingCost, has_steps, training_cost
from hitab_core.training.curriculum import Curriculum
from hitab_core.training.lateness import MEDIANS, SPREADS, Lateness
from hitab_core.training.training_session import TrainingSession
from hitab_core.use import Use

if TYPE_CHECKING:
    import sqlite3

_CURRENT = "(SELECT max(id) FROM training WHERE waits = '')"
_END = f"UPDATE training SET waits = NULL WHERE id = {_CURRENT}"


class TrainingJournal:
    """Keeps trainings and what is known of people on disk, where they survive the process.

    Without a folder it keeps nothing.

    Attributes:
        people: how late the commands of each person come, as far as it is known.
        damage: why the training on disk cannot be resumed, and the way out; empty if none is
            there, or it was resumed.
    """

    def __init__(self, folder: Path | None, domain: str = "") -> None:
        """Name the database; nothing is read or written yet.

        Args:
            folder: of the agent's database; None to keep no journal.
            domain: name of the agent's domain, to begin or resume trainings.
        """
        self._database = None if folder is None else AgentDatabase(folder)
        self.people: dict[str, Lateness] = {}
        self.damage = ""
        self._domain = domain
        self._training = self._written = 0  # the one under way here, and how many records it has

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
        if self._database is None:
            return
        first = {
            "do": "begin",
            "domain": self._domain,
            "curriculum": curriculum.to_record(),
            "examples": [example_record(e) for e in examples],
            "readable": [str(use) for use in readable],
            "at": time.time(),
        }
        if self.damage:
            self._database.put_aside_if_damaged()
        with self._database.transaction(keep=True) as tables:
            tables.execute(_END)
            training = tables.execute("INSERT INTO training (waits) VALUES ('')").lastrowid
            assert training is not None
            self._database.append(tables, training, 1, first)
        self._training, self._written, self.damage = training, 1, ""

    def write(self, record: Mapping[str, object]) -> None:
        """Write what was done; it is on disk when this returns.

        Raises:
            LibraryError: if it cannot be written.
        """
        if self._database is not None and self._training:
            record = {**record, "at": time.time()}
            with self._database.transaction(keep=True) as tables:
                self._database.append(tables, self._training, self._written + 1, record)
            self._written += 1

    def costs(self) -> list[TrainingCost]:
        """Return what the trainings on disk cost, oldest first.

        Those of which nothing is known, in which nothing was done, or whose records are damaged,
        are left out.
        """
        # Only the training that this process has under way goes on.
        costs = (
            _cost(records, time.time() if training == self._training else None)
            for training, records in self._kept()
            if has_steps(records)
        )
        return sorted(filter(None, costs), key=lambda cost: cost.began)

    def unsaved(self) -> TrainingCost | None:
        """Return what the training that the next start resumes has cost so far.

        None: there is none, it is saved already, or it is damaged.
        """
        costs = [_cost(records) for _, records in self._kept(f"WHERE id = {_CURRENT}")]
        return next((cost for cost in costs if cost is not None and not cost.finished), None)

    def _kept(self, which: str = "") -> list[tuple[int, list[dict[str, Any]]]]:
        """Return trainings on disk and their records; damaged ones are left out."""
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
        """Have a training wait for its library, while the agent uses another.

        Args:
            library: the library's folder; empty to resume the training at the next start.
            instead_of: what the training waits for so far.

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
        if self._database is not None and (self._training or self.damage):
            if self.damage:
                self._database.put_aside_if_damaged()
            self._end(self._database)
        self.damage = ""

    def archive(self) -> None:
        """End a saved training; if that fails, the next start does it."""
        if self._database is not None and self._training:
            with suppress(LibraryError):
                self._end(self._database)
        self.close()

    def _end(self, database: AgentDatabase) -> None:
        known = [
            (who, json.dumps(lateness.odds.round(6).tolist()))
            for who, lateness in self.people.items()
        ]
        with database.transaction() as tables:
            tables.execute(_END)
            tables.executemany("REPLACE INTO person VALUES (?, ?)", known)
        self.close()

    def close(self) -> None:
        """Close the database; a training under way stays there."""
        self._training = 0
        if self._database is not None:
            self._database.close()

    def resume(
        self, context: RunContext, has_saved: Callable[[str, str], bool]
    ) -> TrainingSession | None:
        """Return the interrupted training; None if there is none, or `damage` says why not.

        Args:
            context: of the agent.
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
                self.damage = (
                    f"{text}: was written by an earlier HiTAB; save it with that, or {MOVE_AWAY}"
                )
            return None
        session = None
        try:
            if database.is_closed:  # most agents have no training under way, which is soon seen
                with database.as_closed() as tables:
                    if self._read(tables) is None:
                        return None
            with database.transaction(keep=True) as tables:
                training = self._read(tables)
                if training is not None:
                    records = database.records(tables, training)
                    session = self._session(records, context, has_saved)
                    if session is None:
                        tables.execute(_END)
        except FolderInUseError:
            raise
        except LibraryError as error:
            self.damage = str(error)
        except (HitabError, KeyError, TypeError, ValueError) as error:
            self.damage = (
                f"{database.path}: the interrupted training cannot be resumed: {error}; fix that, "
                f"or {MOVE_AWAY}"
            )
        if session is None:
            self.close()
            return None
        self._training, self._written = training or 0, len(records)
        with suppress(LibraryError):  # only what the training took depends on it
            self.write({"do": RESUMED})
        return session

    def _read(self, tables: sqlite3.Connection) -> int | None:
        """Return the training to resume, and read what is known of people and can be used."""
        if tables.execute("PRAGMA schema_version").fetchone() == (0,):
            return None  # the process was killed before it had made the tables
        for who, text in tables.execute("SELECT name, lateness FROM person"):
            with suppress(ValueError):
                odds = np.array(json.loads(text), np.float64)
                if odds.shape == (len(MEDIANS), len(SPREADS)) and (odds >= 0).all() and odds.any():
                    self.people[who] = Lateness(odds / odds.sum())
        training: int | None
        (training,) = tables.execute(f"SELECT {_CURRENT}").fetchone()
        return training

    def _session(
        self,
        records: Sequence[Mapping[str, Any]],
        context: RunContext,
        has_saved: Callable[[str, str], bool],
    ) -> TrainingSession | None:
        """Return the training that its records describe; None if it was saved."""
        begin, *rest = (record for record in records if record.get("do") != RESUMED)
        last = rest[-1] if rest else begin
        if last["do"] == "save" and has_saved(str(last["automaton"]), str(last["checksum"])):
            # The process was killed after saving the behavior and before ending the training.
            return None
        if begin["domain"] != self._domain:
            raise TrainingError(
                f'it is of domain "{begin["domain"]}", and the agent has "{self._domain}"'
            )
        session = TrainingSession(
            context,
            Curriculum.from_record(begin["curriculum"]),
            map(example_of, begin["examples"]),
            self.write,
            tuple(map(Use.parse, begin["readable"])),
            self.people,
        )
        session.replay(rest)
        return session


def _cost(records: Sequence[Mapping[str, Any]], now: float | None = None) -> TrainingCost | None:
    """Return what a training cost; None if nothing is known.

    Args:
        records: of the training.
        now: the time, if the training goes on.
    """
    with suppress(HitabError, KeyError, TypeError, ValueError):
        return training_cost(records, now)
    return None
