"""Reasons why processes of a swarm do not answer, from its supervisor and the system."""

from __future__ import annotations

import threading
import time
from collections.abc import Collection, Mapping
from pathlib import Path

from hitab_client import RunFolder
from hitab_client.runs.run_processes import RunProcesses, Silence
from hitab_ros.timing import HEARTBEAT_S
from hitab_studio.swarm.received_vocabulary import NO_ITEMS


class Processes:
    """Finds out why agents or the world do not answer, without blocking.

    The supervisor is asked in a separate thread, since it may hang as well.

    Args:
        folder: run folder of the swarm; "" if started elsewhere, when no reason is ever known.
    """

    def __init__(self, folder: str) -> None:
        record = RunFolder(Path(folder)).read() if folder else None
        self._processes = RunProcesses(record) if record is not None else None
        self._known: Mapping[str, Silence] = NO_ITEMS
        self._asking: threading.Thread | None = None
        self._next = 0.0

    def process_of(self, name: str) -> str:
        """Return the process that runs an agent, or the agent's name if that is unknown."""
        return name if self._processes is None else self._processes.process_of(name)

    def why(self, absent: Collection[str]) -> Mapping[str, Silence]:
        """Return the known reasons, by process, and refresh them; to be called periodically.

        Args:
            absent: names of agents, or of the world.
        """
        if not absent or self._processes is None:
            self._known = NO_ITEMS
            return NO_ITEMS
        now = time.monotonic()
        if now >= self._next and (self._asking is None or not self._asking.is_alive()):
            self._next = now + HEARTBEAT_S
            self._asking = threading.Thread(
                target=self._ask, args=(self._processes, tuple(absent)), daemon=True
            )
            self._asking.start()
        return {name: why for name, why in self._known.items() if name in absent}

    def _ask(self, processes: RunProcesses, absent: Collection[str]) -> None:
        found = {name: processes.why_silent(name) for name in absent}
        self._known = {name: why for name, why in found.items() if why is not None}
