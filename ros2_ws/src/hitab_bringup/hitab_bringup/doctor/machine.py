"""Checks the computer: Python, the packages, disk, memory and limits."""

from __future__ import annotations

import os
import resource
import shutil
import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from hitab_bringup.doctor.finding import Finding, error, warning
from hitab_bringup.shared_memory import FOLDER, left_behind
from hitab_client.commands import called
from hitab_client.run_folder import state_home

PACKAGES = ("core", "msgs", "ros", "agent", "world", "client", "commander", "studio", "bringup")
PYTHONS = ((3, 11), (3, 13))

MB = 1 << 20
DISK_NEEDED, DISK_WANTED = 100 * MB, 1000 * MB
MEMORY_WANTED = 1000 * MB
FILES_NEEDED = 1024
"""Open files without which the supervisor does not start."""

PROCESSES_WANTED = 4096
"""Processes and threads: a swarm in 100 processes has some 1,500."""

BUFFER = Path("/proc/sys/net/core/rmem_max")
BUFFER_WANTED = 4 * MB
"""The receive buffer for which the DDS profile asks."""


def python() -> Iterator[Finding]:
    """Check the interpreter."""
    found = ".".join(map(str, sys.version_info[:3]))
    told = f"{found} ({sys.executable})"
    if PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        yield Finding("Python", told)
    else:
        yield error("Python", told, "install Python 3.11, 3.12 or 3.13, then run scripts/setup")


def packages() -> Iterator[Finding]:
    """Check that all packages are installed in the same version."""
    versions: dict[str, str] = {}
    for name in PACKAGES:
        try:
            versions[name] = version(f"hitab_{name}")
        except PackageNotFoundError:
            if name != "msgs":  # built by CMake, which registers it with ROS only
                versions[name] = "missing"
    told = ", ".join(sorted(set(versions.values())))
    if len(set(versions.values())) == 1 and "missing" not in versions.values():
        yield Finding("HiTAB", told)
    else:
        told = ", ".join(f"hitab_{name} {found}" for name, found in versions.items())
        yield error("HiTAB", f"its packages differ: {told}", "run scripts/setup")


def home() -> Iterator[Finding]:
    """Check the folder for runs, and the room there."""
    folder = state_home()
    source = next((n for n in ("HITAB_HOME", "XDG_STATE_HOME") if os.environ.get(n)), "")
    told = f"{folder} ({f'from {source}' if source else 'the default; HITAB_HOME changes it'})"
    there = folder
    while not there.exists() and there != there.parent:
        there = there.parent
    if not os.access(there, os.W_OK | os.X_OK) or not there.is_dir():
        yield error("files", f"{told} cannot be written", "name another folder in HITAB_HOME")
        return
    yield Finding("files", told)
    free = shutil.disk_usage(there).free
    room = f"{free // MB:,} MB free"
    if free < DISK_NEEDED:
        yield error("disk", room, f"make room for {folder}, or name another in HITAB_HOME")
    elif free < DISK_WANTED:
        yield warning("disk", room, f"make room for {folder}, or name another in HITAB_HOME")
    else:
        yield Finding("disk", room)


def memory() -> Iterator[Finding]:
    """Check the memory that is available."""
    import psutil  # type: ignore[import-untyped]

    free = psutil.virtual_memory().available
    told = f"{free // MB:,} MB available"
    if free < MEMORY_WANTED:
        yield warning("memory", told, "end other programs; a process takes some 100 MB")
    else:
        yield Finding("memory", told)


def limits() -> Iterator[Finding]:
    """Check the limits that large swarms reach."""
    wrong = False
    for about, what, wanted, option in (
        ("open files", resource.RLIMIT_NOFILE, FILES_NEEDED, "n"),
        ("processes", resource.RLIMIT_NPROC, PROCESSES_WANTED, "u"),
    ):
        _, hard = resource.getrlimit(what)
        if hard == resource.RLIM_INFINITY or hard >= wanted:
            continue
        wrong = True
        report = error if what == resource.RLIMIT_NOFILE else warning
        yield report(
            "limits",
            f"at most {hard} {about} (ulimit -H{option})",
            f"let the administrator raise it to {wanted} or more",
        )
    try:
        buffer = int(BUFFER.read_text(encoding="ascii"))
    except (OSError, ValueError):
        buffer = BUFFER_WANTED
    if buffer < BUFFER_WANTED:
        wrong = True
        yield warning(
            "limits",
            f"at most {buffer // 1024} kB to receive messages in, which is little for a hundred "
            "processes",
            f"sudo sysctl -w net.core.rmem_max={BUFFER_WANTED}",
        )
    if not wrong:
        yield Finding("limits", "high enough for a thousand agents")


def shared_memory(folder: Path = FOLDER) -> Iterator[Finding]:
    """Report what Fast DDS has left in shared memory; HiTAB's own DDS profiles do not use it."""
    own, foreign = left_behind(folder)
    if foreign:
        yield warning(
            "shared memory",
            f"{foreign} files of other users' ROS programs in {folder}",
            "harmless with HiTAB's DDS profiles; with another, its user has to remove them",
        )
    if own:
        yield warning(
            "shared memory",
            f"{own} files in {folder} that ROS programs have left behind",
            f"`{called()} up` and `{called()} down` remove them",
        )
    if not own and not foreign:
        yield Finding("shared memory", f"nothing left behind in {folder}")
