"""Waiting for processes, and having them hang."""

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator

import psutil

from hitab_bringup import RunningSwarm
from hitab_client.runs.run_processes import process_states


def within(seconds: float, condition: Callable[[], object]) -> bool:
    """Wait, without spinning a node, until a condition holds; return whether it did in time."""
    deadline = time.monotonic() + seconds
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


def pid_of(swarm: RunningSwarm, name: str) -> int:
    """Return the process of an agent or the world, 0 while it has none."""
    return next((s["pid"] for s in process_states(swarm.record) if s["name"] == name), 0)


@contextlib.contextmanager
def hanging(swarm: RunningSwarm, name: str) -> Iterator[int]:
    """Have a process hang; it may be killed meanwhile."""
    pid = pid_of(swarm, name)
    os.kill(pid, signal.SIGSTOP)
    assert within(20, lambda: psutil.Process(pid).status() == psutil.STATUS_STOPPED)
    try:
        yield pid
    finally:
        if pid_of(swarm, name) == pid:
            os.kill(pid, signal.SIGCONT)
