"""The state of a process: one that is starved of CPU or disk does not hang."""

from __future__ import annotations

from pathlib import Path

REPLACED_AFTER_S = 10.0
"""Silence of an agent or of a starting relay, s, after which it is replaced; a relay starts
faster even on a busy machine."""


def waits_for_cpu_or_disk(pid: int) -> bool:
    """Return whether a process waits for a CPU or a disk, instead of hanging."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][:1]
    except OSError:
        return False
    return state in ("R", "D")
