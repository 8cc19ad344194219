"""Checks of the computer: Python, HiTAB, disk, memory and limits."""

from __future__ import annotations

import os
import resource
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

from hitab_bringup.doctor.finding import ERROR, WARNING, Finding, judged
from hitab_client.runs.run_folder import state_home
from hitab_core import installed_as, installed_version, way_to_install

PYTHONS = ((3, 11), (3, 13))

MB = 1 << 20
DISK_NEEDED, DISK_WANTED = 100 * MB, 1000 * MB
MEMORY_WANTED = 1000 * MB
FILES_NEEDED = 1024
"""Minimum limit of open files, below which the supervisor does not start."""

PROCESSES_WANTED = 4096
"""Minimum limit of processes and threads: a swarm in 100 processes has some 1,500."""

BUFFER = Path("/proc/sys/net/core/rmem_max")
BUFFER_WANTED = 4 * MB
"""Receive buffer that the DDS profile requests, bytes."""


def python() -> Iterator[Finding]:
    """Check the interpreter, and report the version of HiTAB."""
    text = f"{'.'.join(map(str, sys.version_info[:3]))} ({sys.executable})"
    good = PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]
    way_out = f"install Python 3.11, 3.12 or 3.13; with it, {way_to_install()}"
    yield judged("Python", text, good, way_out, ERROR)
    yield Finding("HiTAB", f"{installed_version()}, {installed_as()}")


def home() -> Iterator[Finding]:
    """Check the folder for runs, and its free space."""
    folder = state_home()
    source = next((n for n in ("HITAB_HOME", "XDG_STATE_HOME") if os.environ.get(n)), "")
    text = f"{folder} ({f'from {source}' if source else 'the default; HITAB_HOME changes it'})"
    parent = folder
    while not parent.exists() and parent != parent.parent:
        parent = parent.parent
    if not os.access(parent, os.W_OK | os.X_OK) or not parent.is_dir():
        way_out = "name another folder in HITAB_HOME"
        yield Finding("files", f"{text} cannot be written", ERROR, way_out)
        return
    yield Finding("files", text)
    free = shutil.disk_usage(parent).free
    way_out = f"make room for {folder}, or name another in HITAB_HOME"
    level = ERROR if free < DISK_NEEDED else WARNING
    yield judged("disk", f"{free // MB:,} MB free", free >= DISK_WANTED, way_out, level)


def memory() -> Iterator[Finding]:
    """Check the available memory."""
    import psutil  # type: ignore[import-untyped]

    free = psutil.virtual_memory().available
    way_out = "end other programs; a process takes some 100 MB"
    yield judged("memory", f"{free // MB:,} MB available", free >= MEMORY_WANTED, way_out)


def limits() -> Iterator[Finding]:
    """Check the limits that large swarms reach."""
    found = []
    for about, what, wanted, option, level in (
        ("open files", resource.RLIMIT_NOFILE, FILES_NEEDED, "n", ERROR),
        ("processes", resource.RLIMIT_NPROC, PROCESSES_WANTED, "u", WARNING),
    ):
        _, hard = resource.getrlimit(what)
        if hard != resource.RLIM_INFINITY and hard < wanted:
            text = f"at most {hard} {about} (ulimit -H{option})"
            way_out = f"let the administrator raise it to {wanted} or more"
            found.append(Finding("limits", text, level, way_out))
    buffer = int(BUFFER.read_text(encoding="ascii")) if BUFFER.exists() else BUFFER_WANTED
    if buffer < BUFFER_WANTED:
        text = (
            f"at most {buffer // 1024} kB to receive messages in, which is little for a hundred "
            "processes"
        )
        way_out = f"sudo sysctl -w net.core.rmem_max={BUFFER_WANTED}"
        found.append(Finding("limits", text, WARNING, way_out))
    yield from found or [Finding("limits", "high enough for a thousand agents")]
