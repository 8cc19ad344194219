"""Which machine has which process of a swarm, as far as it was heard."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from hitab_msgs.msg import MachineProcess, MachineStatus

from hitab_bringup.processes.leases import FIRST_LEASE
from hitab_client import RunRecord
from hitab_machines.machine_signs import MachineSigns

RUNNING, STARTS, STOPPED, ENDED, YIELDED = "running", "starting", "stopped", "ended", "yielded"
"""States of a process; see MachineProcess.msg."""


class ProcessHolders:
    """The machines and the processes that they have.

    Args:
        signs: the signs of the machines.
        record: record of the run.
        own: returns the status of this machine, if it is one.

    Attributes:
        signs: the signs of the machines.
    """

    def __init__(
        self,
        signs: MachineSigns,
        record: RunRecord,
        own: Callable[[], MachineStatus | None] = lambda: None,
    ) -> None:
        self.signs = signs
        self._record = record
        self._own = own

    def statuses(self) -> dict[str, MachineStatus]:
        """Return the last status of each machine of the swarm file, by name."""
        found = {name: heard.status for name, heard in self.signs.heard.items()}
        own = self._own()
        if own is not None:
            found[own.machine] = own
        return {name: found[name] for name in self._record.machines if name in found}

    def _reported(self, process: str) -> Iterator[tuple[str, MachineProcess]]:
        for machine, status in self.statuses().items():
            for inside in status.processes:
                if inside.name == process:
                    yield machine, inside

    def newest_lease(self, process: str) -> int:
        """Return the highest known lease of a process; that of a first start if none is heard."""
        return max(
            (int(inside.lease) for _, inside in self._reported(process)), default=FIRST_LEASE
        )

    def holder(self, process: str) -> str:
        """Return the machine that has a process, or that of the swarm file; empty if unknown."""
        having = [
            (-int(inside.lease), machine)
            for machine, inside in self._reported(process)
            if inside.state != YIELDED
        ]
        if having:
            return min(having)[1]
        machines = self._record.machines.items()
        return next((machine for machine, inside in machines if process in inside), "")

    def held_by(self, machine: str) -> list[str]:
        """Return the processes with agents that a machine has."""
        return [
            process
            for process, agents in self._record.processes.items()
            if agents and self.holder(process) == machine
        ]


def running(status: MachineStatus) -> list[str]:
    """Return the processes with agents that run on a machine."""
    return [p.name for p in status.processes if p.agents and p.state in (RUNNING, STARTS)]
