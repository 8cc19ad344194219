"""Leases of the processes on a machine: which machine runs a process is decided by the highest."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

from hitab_bringup.swarm_files.swarm_description import MachineDescription, SwarmDescription
from hitab_client import SwarmError
from hitab_core.library.durable_files import write_durably

LEASES = "leases.json"
FIRST_LEASE = 1
"""Lease of a process at its first start; each move to another machine adds 1."""


class Leases:
    """The leases in a run folder, by process: those in force here, and those that others have.

    The file has the number of each lease, negative if another machine has it.

    Args:
        folder: path of the run folder.

    Raises:
        SwarmError: if the file cannot be read.
    """

    def __init__(self, folder: Path) -> None:
        self._file = folder / LEASES
        self._known: dict[str, int] = {}
        try:
            known = json.loads(self._file.read_text(encoding="utf-8"))
            if not all(type(lease) is int and lease for lease in known.values()):
                raise ValueError("a lease is a whole number other than 0")
            self._known = dict(known)
        except FileNotFoundError:
            pass
        except (OSError, ValueError, AttributeError) as error:
            raise SwarmError(
                f"{self._file} cannot be read ({error}); remove it, and processes that were moved "
                "here run again where the swarm file says"
            ) from None

    @property
    def taken(self) -> list[str]:
        """The processes with a lease of this machine that a move has given to it."""
        return [process for process, lease in self._known.items() if lease > 0]

    @property
    def known(self) -> list[str]:
        """The processes whose leases are kept."""
        return [*self._known]

    def of(self, process: str) -> int:
        """Return the newest known lease of a process."""
        return abs(self._known.get(process, FIRST_LEASE))

    def is_yielded(self, process: str) -> bool:
        """Whether another machine has the newest known lease of a process."""
        return self._known.get(process, FIRST_LEASE) < 0

    def take(self, process: str, lease: int) -> None:
        """Keep a lease of this machine; it is on disk when this returns."""
        self._keep(process, lease)

    def give_up(self, process: str, lease: int) -> None:
        """Keep the lease of another machine, to which a process has gone."""
        self._keep(process, -lease)

    def _keep(self, process: str, lease: int) -> None:
        if self._known.get(process) != lease:
            self._known[process] = lease
            write_durably(self._file, (json.dumps(self._known, indent=1) + "\n").encode())


def as_leased(swarm: SwarmDescription, folder: Path) -> SwarmDescription:
    """Return a swarm in which this machine runs what it had when it was last up.

    Args:
        swarm: the description.
        folder: path of the run folder.
    """
    leases = Leases(folder)
    taken = [process for process in leases.taken if process in {m.process for m in swarm.members}]

    def leased(machine: MachineDescription) -> MachineDescription:
        is_own = machine.name == swarm.machine
        kept = (p for p in machine.processes if p not in taken and not leases.is_yielded(p))
        if is_own:
            return replace(machine, processes=(*kept, *taken))
        return replace(machine, processes=tuple(p for p in machine.processes if p not in taken))

    return replace(swarm, machines=tuple(map(leased, swarm.machines)))
