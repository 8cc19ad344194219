"""How busy this machine is: a busy one answers late, which is no fault of a node."""

from __future__ import annotations

import os

from hitab_core import quantity

BUSY = 1.5
"""Processes that want to run, for each core, from which on a machine is called busy."""


def busy() -> str:
    """Return that the machine is busy, with its load; "" if it is not."""
    try:
        load = os.getloadavg()[0]
    except OSError:  # the system does not tell
        return ""
    cores = len(os.sched_getaffinity(0))
    if load <= BUSY * cores:
        return ""
    return f"this machine is busy (load {load:.1f} on {quantity(cores, 'core')})"
