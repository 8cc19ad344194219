"""Shared memory that killed processes leave behind.

Fast DDS keeps segments and ports as files ``fastrtps_*`` in shared memory, each with a lock file
that its owner holds. A killed process leaves them behind, and the next one to start logs
``open_and_lock_file failed``, which is harmless but alarming. So files without an owner are
removed.
"""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

FOLDER = Path("/dev/shm")
PREFIX = "fastrtps_"
LOCK_SUFFIXES = ("_el", "_sl")


def remove_stale(folder: Path = FOLDER) -> int:
    """Remove this user's Fast DDS files that no process locks or maps; return their number."""
    groups: dict[str, list[Path]] = {}
    user = os.getuid()
    try:
        for path in folder.glob(f"{PREFIX}*"):
            if path.stat().st_uid == user:
                groups.setdefault(_owner(path.name), []).append(path)
    except OSError:
        return 0
    stale = {name: files for name, files in groups.items() if not any(map(_locked, files))}
    if not stale:
        return 0
    used = _in_use()
    removed = 0
    for files in stale.values():
        if used.isdisjoint(str(path) for path in files):
            for path in files:
                path.unlink(missing_ok=True)
                removed += 1
    return removed


def _owner(name: str) -> str:
    for suffix in LOCK_SUFFIXES:
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
