"""Leases of a machine's processes, in its run folder."""

from __future__ import annotations

import json
import re
from pathlib import Path

from hitab_bringup import SwarmDescription
from hitab_bringup.processes.supervisor_config import COMMANDS_FOLDER

LEASES = "leases.json"


class Leases:
    """The lease of each process of a machine; a yielded one belongs to another machine."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / LEASES
        try:
            self.known: dict[str, int] = json.loads(self._file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            self.known = {}

    def of(self, process: str) -> int:
        return abs(self.known.get(process, 1))

    def is_yielded(self, process: str) -> bool:
        return self.known.get(process, 1) < 0

    def take(self, process: str, lease: int) -> None:
        self._keep(process, lease)

    def give_up(self, process: str, lease: int) -> None:
        self._keep(process, -lease)

    def _keep(self, process: str, lease: int) -> None:
        if self.known.get(process) != lease:
            self.known[process] = lease
            self._file.write_text(json.dumps(self.known), encoding="utf-8")


def described_files(swarm: SwarmDescription) -> dict[str, Path]:
    """Return the swarm file."""
    return {swarm.file.name: swarm.file}


def set_lease(folder: Path, process: str, lease: int) -> None:
    """Write the lease into the command of a process."""
    command = folder / COMMANDS_FOLDER / process
    text = re.sub(r"lease:=\d+", f"lease:={lease}", command.read_text(encoding="utf-8"))
    command.write_text(text, encoding="utf-8")
