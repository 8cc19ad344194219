"""The state of a process: one that is starved of CPU or disk does not hang."""

from __future__ import annotations

from pathlib import Path

REPLACED_AFTER_S = 10.0
"""Silence of an agent or of a starting relay, s, after which it is replaced; a relay starts
faster even on a busy machine."""


def waits_for_cpu_or_disk(pid: int) -> bool:
    """Return whether a thread of a process waits for a CPU or a disk, so that it does not hang.

    The main thread sleeps while the one that wakes it, for a timer or a message, is starved.
    """
    try:
        states = [file.read_text() for file in Path(f"/proc/{pid}/task").glob("*/stat")]
    except OSError:
        return False
    return any(state.rpartition(") ")[2][:1] in ("R", "D") for state in states)
