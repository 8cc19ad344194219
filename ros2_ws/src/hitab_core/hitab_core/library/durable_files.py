"""Writes files atomically, even if the power fails.

A file is written beside its destination, synced to disk and renamed into place; then the folder,
which holds the name, is synced too.
"""

from __future__ import annotations

import errno
import fcntl
import os
import secrets
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hitab_core.texts.errors import FolderInUseError, HitabError, LibraryError

UNFINISHED = ".tmp"
"""Suffix of a file that is being written; leftovers after a crash mean nothing."""

LOCK_TIMEOUT_S = 10.0
"""Seconds to wait for another process to finish with a folder."""

SYNCED_AT_ONCE = 16
"""Maximum number of threads that wait for the disk together."""

_REMEDIES = {
    errno.EACCES: "check its permissions, or use another folder",
    errno.EPERM: "check its permissions, or use another folder",
    errno.EROFS: "the disk is read-only; copy it to a writable one",
    errno.ENOSPC: "make room on the disk",
    errno.EDQUOT: "make room on the disk",
    errno.ENOENT: "check the path",
    errno.ENOTDIR: "a part of the path is a file; check the path",
    errno.EISDIR: "it is a folder; check the path",
    errno.ENAMETOOLONG: "use a shorter name",
}


@contextmanager
def file_errors(
    path: Path, doing: str, *, error: type[HitabError] = LibraryError
) -> Iterator[None]:
    """Turn an error of the operating system into one that names the file and the way out.

    Args:
        path: the file or folder in use.
        doing: the operation, such as "read".
        error: type of the error to raise.

    Raises:
        error: instead of OSError.
    """
    try:
        yield
    except OSError as wrong:
        code = wrong.errno or 0
        reason = os.strerror(code) if code else str(wrong)
        remedy = _REMEDIES.get(code, "check the disk and try again")
        raise error(f"{path}: cannot {doing} it: {reason}; {remedy}") from wrong


def sync_folder(path: Path) -> None:
    """Sync the names in a folder, or the contents of a file, to disk."""
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def sync_together(paths: Iterable[Path]) -> None:
    """Sync files and folders to disk at the same time, which takes about as long as one."""
    from concurrent.futures import ThreadPoolExecutor  # which takes a while to load

    with ThreadPoolExecutor(SYNCED_AT_ONCE) as pool:
        list(pool.map(sync_folder, paths))


def make_folder(folder: Path, *, sync: bool = True) -> None:
    """Make a folder and its parents, if missing, and sync their names to disk.

    Args:
        folder: the folder to make.
        sync: sync the names to disk.
    """
    if not folder.is_dir():
        make_folder(folder.parent, sync=sync)
        folder.mkdir(exist_ok=True)
        if sync:
            sync_folder(folder.parent)


def write_all(descriptor: int, data: bytes) -> None:
    """Write all of ``data``; the operating system may need several calls."""
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


def write_new(path: Path, data: bytes, *, sync: bool = True) -> None:
    """Write a file that is not there yet.

    Args:
        path: path of the file.
        data: contents of the file.
        sync: sync them to disk; syncing its name is up to the caller.

    Raises:
        OSError: if it fails, or the file is there.
    """
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
    try:
        write_all(descriptor, data)
        if sync:
            os.fsync(descriptor)
    finally:
        os.close(descriptor)


def write_durably(path: Path, data: bytes, *, sync: bool = True) -> None:
    """Replace the contents of a file by ``data`` atomically.

    Args:
        path: path of the file, which may be missing.
        data: the new contents.
        sync: sync it to disk; otherwise it may get lost if the power fails.

    Raises:
        OSError: if it fails; the old contents are kept, unless only syncing the new name failed.
    """
    make_folder(path.parent, sync=sync)
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}{UNFINISHED}")
    try:
        write_new(beside, data, sync=sync)
        os.replace(beside, path)
    except BaseException:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        raise
    if sync:
        sync_folder(path.parent)


@contextmanager
def locked(folder: Path, *, alone: bool, patience: float = LOCK_TIMEOUT_S) -> Iterator[None]:
    """Lock a folder: shared, to read, or exclusively (``alone``), to write.

    It is a kernel lock, so it ends with the process, however that ends.

    Raises:
        FolderInUseError: if another process keeps it locked for ``patience`` seconds.
    """
    with file_errors(folder, "lock"):
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        deadline = time.monotonic() + patience
        kind = (fcntl.LOCK_EX if alone else fcntl.LOCK_SH) | fcntl.LOCK_NB
        while True:
            try:
                fcntl.flock(descriptor, kind)
                break
            except BlockingIOError:
                if time.monotonic() > deadline:
                    raise FolderInUseError(
                        f"{folder}: another process has been "
                        f"{'using' if alone else 'writing to'} it for {patience:g} s; "
                        "try again, or end that process"
                    ) from None
                time.sleep(0.001)
            except OSError:
                break  # a file system without locks; single files are still written atomically
        yield
    finally:
        os.close(descriptor)
