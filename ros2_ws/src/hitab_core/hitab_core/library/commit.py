"""Changes several files of a folder atomically, even if the power fails.

The whole change is first written to one file, the note. Once the note is in place the change
counts as made. The next process that opens the folder and finds the note carries it out again from
the beginning.
"""

from __future__ import annotations

import json
import os
import re
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path

from hitab_core.errors import LibraryError
from hitab_core.library.durable_files import (
    LOCK_TIMEOUT_S,
    UNFINISHED,
    file_errors,
    locked,
    make_folder,
    sync_folder,
    write_durably,
)

COMMIT = ".commit.json"
"""The note, which describes the change to make."""

Changes = Mapping[str, bytes | None]
"""New contents of files, by path in the folder; None to remove the file."""

_INSIDE = re.compile(r"(\.?[A-Za-z0-9][A-Za-z0-9_.-]*/)*\.?[A-Za-z0-9][A-Za-z0-9_.-]*\Z")
_HEAD = re.compile(rb"([0-9a-f]{8}) ([0-9]+)\n")


@contextmanager
def held(
    folder: Path, *, alone: bool, patience: float = LOCK_TIMEOUT_S, sync: bool = True
) -> Iterator[None]:
    """Lock a folder: exclusively (``alone``) to write, or shared to read. Do not nest.

    A pending change is carried out first.

    Args:
        folder: of the files; made if it is to be written.
        alone: lock exclusively, to write.
        patience: seconds to wait for other processes.
        sync: if the folder is made, sync it to disk.

    Raises:
        LibraryError: if it cannot be made, or another process keeps it locked.
    """
    with file_errors(folder, "use"):
        if alone:
            make_folder(folder, sync=sync)
        is_there = folder.exists()
    if not is_there:
        yield
        return
    while True:
        with locked(folder, alone=alone, patience=patience):
            if alone:
                finish(folder)
            if alone or not is_unfinished(folder):
                yield
                return
        with locked(folder, alone=True, patience=patience):
            finish(folder)


def commit(folder: Path, changes: Changes) -> None:
    """Write and remove files, all or none. The caller must hold the exclusive lock.

    When this returns, the note is on disk and the change counts as made, even if the files
    themselves could not be written yet.

    Args:
        folder: of the files.
        changes: to make.

    Raises:
        LibraryError: if it cannot be written; nothing has changed.
    """
    finish(folder)
    if not changes:
        return
    with file_errors(folder, "write to"):
        try:
            write_durably(folder / COMMIT, _note(changes))
        except OSError:
            if not _withdrawn(folder):
                return  # the next process finds the note: the change is made
            raise
    # The next process carries out what fails here.
    with suppress(OSError, LibraryError):
        _carry_out(folder, pending(folder))
        _remove_note(folder)


def announce(folder: Path, changes: Changes) -> bytes:
    """Put a note in place without syncing the disk; return its contents.

    The caller must hold the exclusive lock and have carried out earlier changes. From now on the
    change survives this process, and a power failure once the caller has synced the file system.
    Then call `carry_out`, sync again, and call `forget`.

    Raises:
        LibraryError: if it cannot be written; nothing has changed.
    """
    note = _note(changes)
    with file_errors(folder, "write to"):
        write_durably(folder / COMMIT, note, sync=False)
    return note


def withdraw(folder: Path, note: bytes) -> bool:
    """Withdraw an announced note; return whether that was still possible."""
    try:
        with file_errors(folder, "use"), locked(folder, alone=True, patience=0.0):
            return _is_there(folder, note) and _withdrawn(folder)
    except LibraryError:
        return False


def carry_out(folder: Path, note: bytes) -> None:
    """Carry out a note, unless that is done already, without syncing the disk.

    If the folder is locked or the disk fails, a later process carries it out.
    """
    with suppress(OSError, LibraryError), locked(folder, alone=True, patience=0.0):
        if _is_there(folder, note):
            _carry_out(folder, pending(folder), sync=False)


def forget(folder: Path, note: bytes) -> None:
    """Remove a note that was carried out, also on disk, unless that is done already."""
    with suppress(OSError, LibraryError), locked(folder, alone=True, patience=0.0):
        if _is_there(folder, note):
            (folder / COMMIT).unlink()


def is_unfinished(folder: Path) -> bool:
    """Return whether there is a note that may not be carried out yet."""
    return (folder / COMMIT).exists()


def finish(folder: Path) -> None:
    """Carry out the note, if there is one. The caller must hold the exclusive lock.

    Raises:
        LibraryError: if the note makes no sense, or cannot be carried out.
    """
    note = folder / COMMIT
    with file_errors(folder, "write to"):
        there = os.listdir(folder) if folder.is_dir() else []
        for name in there:
            if name.startswith(".") and name.endswith(UNFINISHED):
                (folder / name).unlink(missing_ok=True)
        if COMMIT not in there:
            return
        for left_over in folder.glob(f".*/*/.*{UNFINISHED}"):  # beside versions
            left_over.unlink(missing_ok=True)
        plan = pending(folder)
        if plan:
            # The note may only be announced; it must not get lost half-way through.
            descriptor = os.open(note, os.O_RDONLY | os.O_CLOEXEC)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
            sync_folder(folder)
            _carry_out(folder, plan)
        _remove_note(folder)


def pending(folder: Path) -> dict[str, bytes | None]:
    """Return the changes of a note that may not be carried out yet; empty if there is none.

    Raises:
        LibraryError: if the note makes no sense.
    """
    note = folder / COMMIT
    with file_errors(note, "read"):
        try:
            data = note.read_bytes()
        except FileNotFoundError:
            return {}
    head = _HEAD.match(data)
    body = data[head.end() :] if head is not None else b""
    if b"\0" in data or not data or (head is not None and len(body) < int(head[2])):
        return {}  # the power failed before the note was on disk: the change was never made
    try:
        if head is None or zlib.crc32(body) != int(head[1], 16):
            raise ValueError("checksum mismatch")
        plan = json.loads(body)
        for path, content in plan.items():
            if _INSIDE.match(path) is None or not isinstance(content, str | None):
                raise ValueError(path)
        return {
            path: None if content is None else content.encode("latin-1")
            for path, content in plan.items()
        }
    except (ValueError, AttributeError, TypeError, RecursionError) as error:
        raise LibraryError(
            f"{note}: is not a valid note of a change ({error}); "
            "it was edited by hand: remove it and check the folder's files"
        ) from None


def _note(changes: Changes) -> bytes:
    plan = {
        path: None if data is None else data.decode("latin-1") for path, data in changes.items()
    }
    body = json.dumps(plan).encode()
    return b"%08x %d\n" % (zlib.crc32(body), len(body)) + body


def _is_there(folder: Path, note: bytes) -> bool:
    try:
        return (folder / COMMIT).read_bytes() == note
    except OSError:
        return False


def _withdrawn(folder: Path) -> bool:
    """Remove the note, if any; return whether it is gone."""
    try:
        (folder / COMMIT).unlink(missing_ok=True)
    except OSError:
        return not is_unfinished(folder)
    return True


def _carry_out(folder: Path, plan: Changes, *, sync: bool = True) -> None:
    for path, content in plan.items():
        place = folder / path
        if content is not None:
            write_durably(place, content, sync=sync)
        elif place.exists():
            place.unlink()
            if sync:
                sync_folder(place.parent)


def _remove_note(folder: Path) -> None:
    (folder / COMMIT).unlink()
    sync_folder(folder)
