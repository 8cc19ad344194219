"""Changes several files of a folder by one rename, even if the power fails.

The new files are written to a folder beside and synced to disk. Then that folder is renamed to
`CHANGE`, which makes the change: its files count before the files in their places. At last
its files are moved to their places. A move changes nothing for readers, so an interruption only
leaves moves to the next process that uses the folder.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hitab_core.library.durable_files import (
    LOCK_TIMEOUT_S,
    UNFINISHED,
    file_errors,
    locked,
    make_folder,
    sync_folder,
    sync_together,
    write_new,
)
from hitab_core.texts.errors import LibraryError

CHANGE = ".change"
"""The folder of a change that was made and is not in its places yet."""

Changes = dict[str, bytes | None]
"""New contents of files, by path in the folder; None to remove the file."""

_SLASH = "+"
"""Stands for the slash of a path in names of files in `CHANGE`."""

_REMOVED = ".removed"
"""Ending of the name of a file in `CHANGE` whose place becomes empty."""


@contextmanager
def held(folder: Path, *, alone: bool, patience: float = LOCK_TIMEOUT_S) -> Iterator[None]:
    """Lock a folder: exclusively (``alone``) to write, or shared to read. Do not nest.

    Args:
        folder: folder of the files; created for writing if missing.
        alone: lock exclusively, to write.
        patience: seconds to wait for other processes.

    Raises:
        LibraryError: if it cannot be made, or another process keeps it locked.
    """
    with file_errors(folder, "use"):
        if alone:
            make_folder(folder)
        is_there = folder.exists()
    if is_there and not alone and (folder / CHANGE).exists():
        with suppress(LibraryError, OSError), locked(folder, alone=True, patience=0.0):
            _put_in_place(folder)  # for people who look into the folder
    if not is_there:
        yield
        return
    with locked(folder, alone=alone, patience=patience):
        yield


def commit(folder: Path, changes: Changes) -> None:
    """Write and remove files, all or none. The caller must hold the exclusive lock.

    When this returns, the change is on disk.

    Raises:
        LibraryError: if it cannot be written; nothing has changed.
    """
    change = folder / CHANGE
    beside = folder / f".{secrets.token_hex(4)}{UNFINISHED}"
    with file_errors(folder, "write to"):
        _put_in_place(folder)
        if not changes:
            return
        try:
            os.mkdir(beside)
            for path, data in changes.items():
                name = path.replace("/", _SLASH)
                write_new(beside / (name + _REMOVED * (data is None)), data or b"", sync=False)
            sync_together([beside, *beside.iterdir()])
            os.rename(beside, change)
            sync_folder(folder)
        except OSError:
            with suppress(OSError):
                os.rename(change, beside)
            shutil.rmtree(beside, ignore_errors=True)
            if not change.exists():  # otherwise it cannot be taken back, so it is made
                raise
    with suppress(OSError):
        _put_in_place(folder)


def files_in(folder: Path, inside: str = "") -> dict[str, Path]:
    """Return where the files of a folder are, by name.

    Args:
        folder: folder that `commit` changes.
        inside: path of a folder in it; empty for the folder itself.

    Raises:
        LibraryError: if it cannot be read.
    """
    with file_errors(folder / CHANGE, "read"):
        made = _listed(folder / CHANGE)
    with file_errors(folder, "read"):
        place_of = folder / inside
        found = {name: place_of / name for name in _listed(place_of)}
        for path in (folder / CHANGE / name for name in made):
            place, _, name = path.name.replace(_SLASH, "/").rpartition("/")
            if place == inside and path.exists():  # it may be put in place meanwhile
                if name.endswith(_REMOVED):
                    found.pop(name.removesuffix(_REMOVED), None)
                else:
                    found[name] = path
    return found


def _listed(folder: Path) -> list[str]:
    try:
        return os.listdir(folder)
    except FileNotFoundError:
        return []


def _put_in_place(folder: Path) -> None:
    """Move the files of a change to their places, and remove leftovers of an interruption."""
    for left_over in folder.glob(f".*{UNFINISHED}"):
        if left_over.is_dir():
            shutil.rmtree(left_over)
        else:
            left_over.unlink()
    change = folder / CHANGE
    made = _listed(change)
    removed = [name for name in made if name.endswith(_REMOVED)]
    for name in removed:
        path = name.removesuffix(_REMOVED).replace(_SLASH, "/")
        (folder / path).unlink(missing_ok=True)
    if removed:
        sync_folder(folder)  # before that is forgotten
    for name in made:
        if name in removed:
            (change / name).unlink()
        else:
            place = folder / name.replace(_SLASH, "/")
            make_folder(place.parent, sync=False)
            os.replace(change / name, place)
    if change.exists():
        change.rmdir()
