"""The database of one agent, in which its trainings outlive its process.

SQLite locks the file, and a transaction is on disk as a whole or not at all. The file is made at
the first write, and open only while it is used: for as long as a training is under way, which
keeps other processes out, or for one transaction. It needs a local file system, not NFS.
"""

from __future__ import annotations

import errno
import json
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hitab_core.library.durable_files import file_errors, make_folder
from hitab_core.texts.errors import FolderInUseError, LibraryError, newer_format

if TYPE_CHECKING:  # importing it takes 10 ms, which most processes need not spend
    import sqlite3

DATABASE_FILE = "agent.db"
DATABASE_FORMAT = 4
"""The format version that is written; 1 and 2 were journals of text, 3 had no operations."""

_SCHEMA = f"""
CREATE TABLE training (id INTEGER PRIMARY KEY, waits TEXT);
CREATE TABLE record (key INTEGER PRIMARY KEY, text TEXT NOT NULL, crc INTEGER NOT NULL);
CREATE TABLE person (name TEXT PRIMARY KEY, lateness TEXT NOT NULL);
PRAGMA user_version = {DATABASE_FORMAT}
"""
_REMEDIES = {
    "SQLITE_FULL": "make room on the disk",
    "SQLITE_IOERR": "check the disk and try again",
    "SQLITE_CANTOPEN": "check its permissions, or use another folder",
}
MOVE_AWAY = "discard the training, or move this file away to start without it"
OLDER = f"was written by an earlier HiTAB; save it with that, or {MOVE_AWAY}"


class AgentDatabase:
    """The tables of an agent: `training`, `record` and `person`.

    `training.waits` is empty for the training that the next start resumes, NULL for an ended one,
    or the library of the training, while the agent uses another. A record's key is
    ``training << 32 | number``, so a training is read without an index.

    Attributes:
        path: path of the file.
    """

    def __init__(self, folder: Path) -> None:
        """Name the file; nothing is read or written yet."""
        self.path = folder / DATABASE_FILE
        self._open: sqlite3.Connection | None = None
        self._opened = 0  # identity of the file

    @contextmanager
    def transaction(self, *, keep: bool = False) -> Iterator[sqlite3.Connection]:
        """Make changes that are on disk when this ends, or undone if it raises.

        Args:
            keep: keep the file open afterwards, and other processes out, until `close`.

        Raises:
            FolderInUseError: if another process uses it.
            LibraryError: if it cannot be read or written.
        """
        with _errors(self.path):
            if self._open is not None and self._opened != self._found:
                self._write_afresh(self._open)
            tables = self._open or self._connected()
            try:
                tables.execute("BEGIN IMMEDIATE")
                yield tables
                tables.execute("COMMIT")
                if keep:
                    self._open, self._opened = tables, self._found
            except BaseException:
                if tables.in_transaction:
                    tables.rollback()
                raise
            finally:
                if self._open is not tables:
                    tables.close()

    def close(self) -> None:
        """Close the file; other processes can use it then."""
        tables, self._open = self._open, None
        if tables is not None:
            tables.close()

    def put_aside_if_damaged(self) -> None:
        """Rename a file that is not sound: ``agent.db`` becomes ``agent.1.db``, or the next.

        Raises:
            FolderInUseError: if another process uses it.
            LibraryError: if that fails.
        """
        try:
            with self.transaction() as tables:
                if tables.execute("PRAGMA quick_check").fetchone() == ("ok",):
                    return
        except FolderInUseError:
            raise
        except LibraryError:
            pass
        number = 1
        while (aside := self.path.with_name(f"agent.{number}.db")).exists():
            number += 1
        with file_errors(self.path, "rename"):
            for end in ("-wal", ""):  # if this is killed between, the file is still damaged
                with suppress(FileNotFoundError):
                    os.rename(f"{self.path}{end}", f"{aside}{end}")

    @property
    def is_closed(self) -> bool:
        """Whether the file is there and no process has it open, or was killed while it had."""
        return self.path.exists() and not Path(f"{self.path}-wal").exists()

    @contextmanager
    def as_closed(self) -> Iterator[sqlite3.Connection]:
        """Read the file as it was last closed, which takes no lock and writes nothing.

        Raises:
            LibraryError: if it cannot be read.
        """
        with _errors(self.path):
            import sqlite3

            uri = f"{self.path.absolute().as_uri()}?immutable=1"
            with closing(sqlite3.connect(uri, uri=True)) as tables:
                self._check_version(tables)
                yield tables

    def _check_version(self, tables: sqlite3.Connection) -> int:
        (version,) = tables.execute("PRAGMA user_version").fetchone()
        if version > DATABASE_FORMAT:
            raise LibraryError(f"{self.path}: {newer_format(version, DATABASE_FORMAT)}")
        if 0 < version < DATABASE_FORMAT:
            raise LibraryError(f"{self.path}: {OLDER}")
        return int(version)

    def append(
        self, tables: sqlite3.Connection, training: int, number: int, record: Mapping[str, object]
    ) -> None:
        """Add a record, the first one with number 1, to a training.

        Raises:
            LibraryError: if JSON cannot represent it.
        """
        try:
            text = json.dumps(record, allow_nan=False)
        except (TypeError, ValueError, RecursionError) as error:
            raise LibraryError(f"{self.path}: cannot hold this record: {error}") from None
        row = (training << 32 | number, text, _crc(text))
        tables.execute("INSERT INTO record VALUES (?, ?, ?)", row)

    def records(self, tables: sqlite3.Connection, training: int) -> list[dict[str, Any]]:
        """Return the records of a training, oldest first.

        Raises:
            LibraryError: if one is damaged or missing.
        """
        records: list[dict[str, Any]] = []
        keys = (training << 32, (training + 1) << 32)
        for key, text, crc in tables.execute(
            "SELECT key, text, crc FROM record WHERE key > ? AND key < ? ORDER BY key", keys
        ):
            number = len(records) + 1
            if key != keys[0] + number or crc != _crc(text):
                raise LibraryError(
                    f"{self.path}: record {number} of training {training} was damaged or edited; "
                    f"{MOVE_AWAY}"
                )
            records.append(json.loads(text))
        return records

    @property
    def _found(self) -> int:
        """The identity of the file with this name; 0 if there is none."""
        return self.path.stat().st_ino if self.path.exists() else 0

    def _connected(self) -> sqlite3.Connection:
        import sqlite3

        make_folder(self.path.parent)
        for path in (self.path.parent, self.path):
            if path.exists() and not os.access(path, os.W_OK):
                raise PermissionError(errno.EACCES, "Permission denied")  # SQLite: "I/O error"
        tables = sqlite3.connect(
            self.path, timeout=0.0, isolation_level=None, check_same_thread=False
        )
        try:
            for value in ("locking_mode = EXCLUSIVE", "journal_mode = WAL", "synchronous = FULL"):
                tables.execute(f"PRAGMA {value}")
            if self._check_version(tables) == 0:
                tables.execute("BEGIN IMMEDIATE")
                for statement in _SCHEMA.split(";"):
                    tables.execute(statement)
                tables.execute("COMMIT")
        except BaseException:
            tables.close()
            raise
        return tables

    def _write_afresh(self, removed: sqlite3.Connection) -> None:
        """Write everything again after the file or its folder was removed."""
        import sqlite3

        if self._found:
            raise FolderInUseError(f"{self.path}: was replaced by another file; start again")
        make_folder(self.path.parent)
        beside = self.path.with_suffix(".tmp")
        with closing(sqlite3.connect(beside)) as copy:
            removed.backup(copy)
        self.close()  # before there is another file of this name
        beside.replace(self.path)
        self._open, self._opened = self._connected(), self._found


def _crc(text: str) -> int:
    return zlib.crc32(text.encode())


@contextmanager
def _errors(path: Path) -> Iterator[None]:
    """Turn an error of SQLite into one that names the file and the way out."""
    import sqlite3

    with file_errors(path, "use"):
        try:
            yield
        except sqlite3.Error as error:
            name = getattr(error, "sqlite_errorname", "")
            if name.startswith("SQLITE_BUSY"):
                raise FolderInUseError(
                    f"{path}: is in use by another process; end it, or use another folder"
                ) from None
            kind = "_".join(name.split("_")[:2])
            remedy = _REMEDIES.get(kind, MOVE_AWAY)
            raise LibraryError(f"{path}: cannot use it: {error}; {remedy}") from error
