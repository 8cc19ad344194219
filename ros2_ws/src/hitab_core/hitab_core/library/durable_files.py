"""Files that are there whole or not at all, also when the power fails in the middle.

A file is written beside its place, forced to disk and renamed into place; then the folder, which
holds the name, is forced to disk too.
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import secrets
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from hitab_core.errors import FolderInUseError, LibraryError

UNFINISHED = ".tmp"
"""Ending of a file that is being written; what is left of it after a crash means nothing."""

FEW_FOLDERS = 20
"""So many are forced to disk one by one; of more, their file systems."""

PATIENCE = 10.0
"""Seconds to wait for another process to finish with a folder."""

_REMEDIES = {
    errno.EACCES: "give yourself the right to, or use another folder",
    errno.EPERM: "give yourself the right to, or use another folder",
    errno.EROFS: "copy it to a disk that can be written",
    errno.ENOSPC: "make room on the disk",
    errno.EDQUOT: "make room on the disk",
    errno.ENOENT: "look for a mistyped name",
    errno.ENOTDIR: "a part of the path is a file; look for a mistyped name",
    errno.EISDIR: "it is a folder; look for a mistyped name",
    errno.ENAMETOOLONG: "use a shorter name",
}


@contextmanager
def file_errors(path: Path, doing: str) -> Iterator[None]:
    """Turn an error of the operating system into one that names the file and the way out.

    Args:
        path: what is being worked on.
        doing: what cannot be done, such as "read".

    Raises:
        LibraryError: instead of OSError.
    """
    try:
        yield
    except OSError as error:
        code = error.errno or 0
        reason = os.strerror(code) if code else str(error)
        remedy = _REMEDIES.get(code, "look after the disk and try again")
        raise LibraryError(f"{path}: cannot {doing} it: {reason}; {remedy}") from error


def sync_folder(folder: Path) -> None:
    """Force the names in a folder to disk."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def make_folder(folder: Path, *, sync: bool = True) -> None:
    """Make a folder, and those it is in, and force their names to disk; it may be there.

    Args:
        folder: what to make.
        sync: force the names to disk; otherwise that is left to the caller.
    """
    if not folder.is_dir():
        make_folder(folder.parent, sync=sync)
        folder.mkdir(exist_ok=True)
        if sync:
            sync_folder(folder.parent)


def write_all(descriptor: int, data: bytes) -> None:
    """Write all of ``data``; the operating system may take several goes."""
    view = memoryview(data)
    while view:
        view = view[os.write(descriptor, view) :]


def sync_trees(folders: Iterable[Path]) -> None:
    """Force all that was written into some folders, and those inside them, to disk.

    Of a few folders each file is forced: that does not wait for what other programs have written.
    Of many the whole file system is, which takes about as long as `os.fsync` of one file.

    Raises:
        OSError: if that cannot be done.
    """
    folders = list(folders)
    if len(folders) <= FEW_FOLDERS:
        for folder in folders:
            _sync_tree(folder)
        return
    seen: set[int] = set()
    for folder in folders:
        descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_CLOEXEC)
        try:
            device = os.fstat(descriptor).st_dev
            if device not in seen:
                seen.add(device)
                _sync_filesystem(descriptor)
        finally:
            os.close(descriptor)


def _sync_tree(folder: Path) -> None:
    for place, _, files in os.walk(folder):
        for name in files:
            descriptor = os.open(Path(place) / name, os.O_RDONLY | os.O_CLOEXEC)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
        sync_folder(Path(place))


def _sync_filesystem(descriptor: int) -> None:
    syncfs = getattr(ctypes.CDLL(None, use_errno=True), "syncfs", None)
    if syncfs is None:
        os.sync()
    elif syncfs(descriptor):
        code = ctypes.get_errno()
        raise OSError(code, os.strerror(code))


def write_durably(path: Path, data: bytes, *, sync: bool = True) -> None:
    """Put ``data`` into a file, in the place of what was there, whole or not at all.

    Args:
        path: of the file.
        data: all that it will hold.
        sync: force it to disk; otherwise the caller does, with `sync_trees`.

    Raises:
        OSError: if it cannot be done; then what was there still is, unless only the new name
            could not be forced to disk.
    """
    make_folder(path.parent, sync=sync)
    beside = path.with_name(f".{path.name}.{secrets.token_hex(4)}{UNFINISHED}")
    descriptor = os.open(beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, 0o666)
    try:
        try:
            write_all(descriptor, data)
            if sync:
                os.fsync(descriptor)
        finally:
            os.close(descriptor)
        os.replace(beside, path)
    except BaseException:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        raise
    if sync:
        sync_folder(path.parent)


@contextmanager
def locked(folder: Path, *, alone: bool, patience: float = PATIENCE) -> Iterator[None]:
    """Hold a folder: many may hold it to read, or one ``alone`` to write.

    The lock is the kernel's: it ends with the process, however that ends.

    Raises:
        FolderInUseError: if somebody else does not let go for ``patience`` seconds.
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
                break  # a file system without locks; single files are still whole or not there
        yield
    finally:
        os.close(descriptor)
