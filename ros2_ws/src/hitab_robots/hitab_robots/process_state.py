"""Tells a process that hangs from one that this machine holds up."""

from __future__ import annotations

from pathlib import Path


def waits_for_cpu_or_disk(pid: int) -> bool:
    """Whether a process would go on if it only got a processor, or its disk."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(") ")[2][:1]
    except OSError:
        return False
    return state in ("R", "D")
