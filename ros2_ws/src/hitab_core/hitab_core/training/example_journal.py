"""A training on disk, record by record, so that no acknowledged example is ever lost.

One JSON object per line: the format version, a number counting from 1, a checksum and the record.
A record counts once its line is complete; a truncated line was never acknowledged and is dropped.
"""

from __future__ import annotations

import fcntl
import json
import os
import zlib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, Self

from hitab_core.errors import FolderInUseError, LibraryError, newer_format
from hitab_core.library.durable_files import file_errors, make_folder, sync_folder, write_all

JOURNAL_FORMAT = 2
"""The format version that is written."""


class ExampleJournal:
    """The journal of one training, opened by one process at a time.

    Use `open` or `begin`, not the constructor.

    Attributes:
        path: of the file.
        records: that were written, oldest first.
    """

    def __init__(self, path: Path, descriptor: int) -> None:
        """Take over an open, locked file."""
        self.path = path
        self._descriptor = descriptor
        self.records: list[dict[str, Any]] = []
        self._size = 0

    @classmethod
    def open(cls, path: Path | str) -> Self:
        """Open a journal to resume it, or begin one.

        A truncated last line is removed.

        Raises:
            LibraryError: if it cannot be read or written, is open in another process, or, naming
                the line, is damaged.
        """
        path = Path(path)
        with file_errors(path, "open"):
            make_folder(path.parent)
            descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
            journal = cls(path, descriptor)
            try:
                journal._lock()
                journal._resume()
                sync_folder(path.parent)
            except BaseException:
                os.close(descriptor)
                raise
        return journal

    @classmethod
    def begin(cls, path: Path | str, first: Mapping[str, Any]) -> Self:
        """Begin a journal; archive an existing one.

        Args:
            path: of the journal.
            first: its first record.

        Raises:
            LibraryError: if it cannot be written; the existing journal is unchanged.
        """
        path = Path(path)
        beside = path.with_name(f"{path.stem}.next{path.suffix}")
        with file_errors(beside, "remove"):
            beside.unlink(missing_ok=True)  # left by a killed process
        journal = cls.open(beside)
        try:
            journal.append(first)
            with file_errors(path, "begin"):
                earlier = _free_name(path) if path.exists() else None
                if earlier is not None:
                    path.rename(earlier)
                try:
                    beside.rename(path)
                    sync_folder(path.parent)
                except BaseException:
                    if earlier is not None:
                        with suppress(OSError):
                            earlier.rename(path)
                    raise
        except BaseException:
            journal.close()
            with suppress(OSError):
                beside.unlink(missing_ok=True)
            raise
        journal.path = path
        return journal

    def append(self, record: Mapping[str, Any]) -> None:
        """Write a record; when this returns, it is on disk.

        Args:
            record: anything that JSON can represent.

        Raises:
            LibraryError: if it cannot be written; the journal is unchanged.
        """
        try:
            kept = json.loads(json.dumps(record, allow_nan=False))
        except (TypeError, ValueError, RecursionError) as error:
            raise LibraryError(f"{self.path}: cannot hold this record: {error}") from None
        data = _line(len(self.records) + 1, kept)
        with file_errors(self.path, "write to"):
            if not os.fstat(self._open()).st_nlink:
                self._write_afresh()
            if os.fstat(self._descriptor).st_size != self._size:
                os.ftruncate(self._descriptor, self._size)  # what could not be removed before
            try:
                write_all(self._descriptor, data)
                os.fsync(self._descriptor)
            except OSError:
                with suppress(OSError):  # half a line is also dropped when the journal is reopened
                    os.ftruncate(self._descriptor, self._size)
                raise
        self._size += len(data)
        self.records.append(kept)

    def close(self) -> None:
        """Close it, to be resumed later."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1

    def discard(self) -> None:
        """Close it and remove its file.

        Raises:
            LibraryError: if that fails.
        """
        with file_errors(self.path, "remove"):
            self.path.unlink(missing_ok=True)
        self.close()

    def archive(self) -> Path:
        """Close the journal and rename its file, so that no process resumes it.

        Returns:
            The file: ``training.jsonl`` becomes ``training.1.jsonl``, or the next free number.

        Raises:
            LibraryError: if that fails.
        """
        archived = archive(self.path)
        self.close()
        return archived

    def _open(self) -> int:
        if self._descriptor < 0:
            raise LibraryError(f"{self.path}: is closed; reopen it to write to it")
        return self._descriptor

    def _write_afresh(self) -> None:
        """Rewrite everything after the file or its folder was removed."""
        again = type(self).open(self.path)
        try:
            for record in self.records[len(again.records) :]:
                again.append(record)
        except BaseException:
            again.close()
            raise
        os.close(self._descriptor)
        self._descriptor, self._size = again._descriptor, again._size

    def _lock(self) -> None:
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if not os.path.samestat(os.fstat(self._descriptor), self.path.stat()):
                raise BlockingIOError  # renamed or removed while opening it
        except (BlockingIOError, FileNotFoundError):
            raise FolderInUseError(
                f"{self.path}: is in use by another process; end it, or use another folder"
            ) from None

    def _resume(self) -> None:
        data = self.path.read_bytes()
        whole, _, torn = data.rpartition(b"\n")
        lines = whole.split(b"\n") if whole else []
        # After a power failure the last write may be zeros on disk.
        if lines and b"\0" in lines[-1] and not torn:
            torn = lines.pop()
        for number, line in enumerate(lines, 1):
            self.records.append(_record(line, number, f"{self.path.name}:{number}"))
        self._size = sum(len(line) + 1 for line in lines)
        if self._size < len(data):
            os.ftruncate(self._descriptor, self._size)
        os.fsync(self._descriptor)


def records_in(path: Path) -> list[dict[str, Any]]:
    """Return the sound records of a journal that may be open elsewhere, from its beginning."""
    records: list[dict[str, Any]] = []
    with suppress(OSError, LibraryError):
        for number, line in enumerate(path.read_bytes().split(b"\n")[:-1], 1):
            records.append(_record(line, number, path.name))
    return records


def archive(path: Path) -> Path:
    """Rename a journal, so that no process resumes it; see `ExampleJournal.archive`."""
    with file_errors(path, "rename"):
        archived = _free_name(path)
        if path.exists():  # else it was removed by other means
            path.rename(archived)
            # At worst a power failure restores the old name.
            with suppress(OSError):
                sync_folder(path.parent)
    return archived


def _free_name(path: Path) -> Path:
    number = 1
    while (archived := path.with_name(f"{path.stem}.{number}{path.suffix}")).exists():
        number += 1
    return archived


def _line(number: int, record: Mapping[str, Any]) -> bytes:
    text = json.dumps(record)
    line = f'{{"journal": {JOURNAL_FORMAT}, "number": {number}, "crc": "{_crc(text)}", "record": '
    return f"{line}{text}}}\n".encode()


def _crc(text: str) -> str:
    return f"{zlib.crc32(text.encode()):08x}"


def _record(line: bytes, number: int, place: str) -> dict[str, Any]:
    damaged = "keep a copy, delete this line and all below it, and start the agent again"
    try:
        entry = json.loads(line)
        version, found, crc, record = (entry[k] for k in ("journal", "number", "crc", "record"))
    except (ValueError, KeyError, TypeError, RecursionError):
        raise LibraryError(f"{place}: is not a record of a journal; {damaged}") from None
    if version != JOURNAL_FORMAT:
        raise LibraryError(
            f"{place}: {newer_format(version, JOURNAL_FORMAT)}, or use the version that wrote it"
        )
    if found != number:
        raise LibraryError(f"{place}: has number {found} instead of {number}; {damaged}")
    if crc != _crc(json.dumps(record)) or not isinstance(record, dict):
        raise LibraryError(f"{place}: was damaged or edited (its digest does not fit); {damaged}")
    return record
