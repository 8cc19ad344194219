"""Shared memory that killed ROS programs leave behind.

Fast DDS keeps segments and ports as files ``fastrtps_*`` in shared memory, each with a lock file
that its owner holds, and a semaphore ``sem.fastrtps_*_mutex`` for each port. A killed process
leaves them behind, and the next one to start logs ``open_and_lock_file failed``, which is harmless
but alarming. HiTAB's own DDS profiles use no shared memory; a user's own may. So files without an
owner are removed.
"""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

FOLDER = Path("/dev/shm")
PREFIX = "fastrtps_"
SEMAPHORE = "sem."
SUFFIXES = ("_el", "_sl", "_mutex")
LOCK_SUFFIXES = ("_el", "_sl")


def remove_stale(folder: Path = FOLDER) -> int:
    """Remove this user's Fast DDS files that no process locks or maps; return their number."""
    stale = _stale(folder)
    for path in stale:
        path.unlink(missing_ok=True)
    return len(stale)


def left_behind(folder: Path = FOLDER) -> tuple[int, int]:
    """Return the number of this user's files without an owner, and of other users' files."""
    foreign = 0
    for path in _files(folder):
        try:
            foreign += path.stat().st_uid != os.getuid()
        except OSError:
            continue  # removed in the meantime
    return len(_stale(folder)), foreign


def _files(folder: Path) -> list[Path]:
    try:
        return [*folder.glob(f"{PREFIX}*"), *folder.glob(f"{SEMAPHORE}{PREFIX}*")]
    except OSError:
        return []


def _stale(folder: Path) -> list[Path]:
    """Return this user's files that no process locks or maps."""
    groups: dict[str, list[Path]] = {}
    user = os.getuid()
    try:
        for path in _files(folder):
            if path.stat().st_uid == user:
                groups.setdefault(_owner(path.name), []).append(path)
    except OSError:
        return []
    stale = [files for files in groups.values() if not any(map(_locked, files))]
    if not stale:
        return []
    used = _in_use()
    return [f for files in stale if used.isdisjoint(str(path) for path in files) for f in files]


def _owner(name: str) -> str:
    name = name.removeprefix(SEMAPHORE)
    for suffix in SUFFIXES:
        name = name.removesuffix(suffix)
    return name


def _locked(path: Path) -> bool:
    if not path.name.endswith(LOCK_SUFFIXES):
        return False
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return True
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return True
    finally:
        os.close(descriptor)
    return False


def _in_use() -> set[str]:
    """Return the files with our prefix that a process has mapped or open."""
    found: set[str] = set()
    for process in Path("/proc").glob("[0-9]*"):
        try:
            maps = (process / "maps").read_text(errors="replace")
            if PREFIX in maps:
                found.update(
                    line.split(maxsplit=5)[5] for line in maps.splitlines() if PREFIX in line
                )
            for descriptor in (process / "fd").iterdir():
                target = os.readlink(descriptor)
                if PREFIX in target:
                    found.add(target)
        except OSError:
            continue  # ended in the meantime, or another user's
    return found
