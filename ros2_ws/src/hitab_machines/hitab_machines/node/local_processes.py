"""The processes of a machine: their states for others, their logs, and the start of another."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

from hitab_msgs.msg import MachineProcess

from hitab_bringup.processes.leases import Leases
from hitab_client import RunFolder, RunRecord, SwarmError
from hitab_client.runs.run_processes import (
    ENDED_STATES,
    STOPPED_STATES,
    is_starting,
    process_states,
)
from hitab_core import HitabError, has
from hitab_machines.process_holders import ENDED, RUNNING, STARTS, STOPPED
from hitab_ros.leases import YIELDED
from hitab_ros.timing import UPDATE_S

LINES_MAX = 1000
"""Maximum number of lines of a log in an answer."""

LOG_BYTES_MAX = 1_000_000
"""Maximum size of the part of a log in an answer."""


class LocalProcesses:
    """The processes of a swarm on this machine.

    Args:
        folder: the run folder.
        record: record of the run.
        leases: the leases of this machine.
    """

    def __init__(self, folder: RunFolder, record: RunRecord, leases: Leases) -> None:
        self._folder = folder
        self._record = record
        self._leases = leases
        self._states: Mapping[str, Mapping[str, Any]] = {}

    def statuses(self) -> list[MachineProcess]:
        """Return the processes that this machine was started with or has taken over."""
        try:
            found = process_states(self._record, UPDATE_S)
            self._states = {state["name"]: state for state in found}
        except SwarmError:  # it is busy, such as with a start; its last answer stays
            pass
        mine = dict.fromkeys((*self._record.processes_here, *self._leases.known))
        return [
            MachineProcess(
                name=name,
                state=self._state(name),
                lease=self._leases.of(name),
                agents=self._record.processes.get(name, ()),
            )
            for name in mine
        ]

    def _state(self, name: str) -> str:
        yielded = self._leases.is_yielded(name)
        state = self._states.get(name, {"statename": "EXITED" if yielded else "STARTING"})
        said = state["statename"]
        if yielded and said in ENDED_STATES:
            return YIELDED
        if is_starting(state):
            return STARTS
        if said in STOPPED_STATES:
            return STOPPED
        return RUNNING if said == "RUNNING" else ENDED

    def log(self, process: str, position: int, lines: int) -> tuple[list[str], int]:
        """Return lines of a process's log, and where to go on.

        Args:
            process: name of the process, or supervisor.
            position: where to begin, in bytes; 0 for the last lines.
            lines: maximum number of lines.

        Raises:
            HitabError: if there is no such log.
        """
        logs = {path.stem: path for path in (self._folder.path / "logs").glob("*.log")}
        logs["supervisor"] = self._folder.path / "supervisord.log"
        if process not in logs:
            raise HitabError(
                f'nothing called "{process}" ran on {self._record.machine} {has(logs, process)}'
            )
        with logs[process].open("rb") as file:
            size = file.seek(0, os.SEEK_END)
            position = position if position <= size else 0  # the supervisor began a new file
            start = position or max(0, size - LOG_BYTES_MAX)
            file.seek(start)
            data = file.read(LOG_BYTES_MAX)
        data = data[: data.rfind(b"\n") + 1]
        found = data.splitlines(keepends=True)
        most = min(lines, LINES_MAX)
        chosen = found[:most] if position else found[len(found) - min(most, len(found)) :]
        left = sum(map(len, found[most:])) if position else 0
        texts = [line.decode(errors="replace").rstrip("\n") for line in chosen]
        return texts, start + len(data) - left
