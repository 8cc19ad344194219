"""Which machine has which process of a swarm, as far as it was heard."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from hitab_msgs.msg import MachineProcess, MachineStatus

from hitab_bringup.processes.leases import FIRST_LEASE
from hitab_client import MachineSigns, RunRecord
from hitab_ros.leases import YIELDED, machine_rank

RUNNING, STARTS, STOPPED, ENDED = "running", "starting", "stopped", "ended"
"""States of a process, besides `YIELDED`; see MachineProcess.msg."""

LEASE_MAX = 10**9
"""Maximum number of a lease, whatever is received: leases count moves, and must not run out."""


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
        found = self.signs.statuses()
        own = self._own()
        if own is not None:
            found[own.machine] = own
        return {name: found[name] for name in self._record.machines if name in found}

    def _reported(self, process: str) -> Iterator[tuple[str, MachineProcess]]:
        for machine, status in self.statuses().items():
            for inside in status.processes:
                if inside.name == process and inside.lease <= LEASE_MAX:
                    yield machine, inside

    def newest_lease(self, process: str) -> int:
        """Return the highest known lease of a process; that of a first start if none is heard."""
        return max(
            (int(inside.lease) for _, inside in self._reported(process)), default=FIRST_LEASE
        )

    def holder(self, process: str) -> str:
        """Return the machine that has a process; empty if unknown.

        If none has, it is the one that had it last, or that of the swarm file.
        """
        having = [
            (machine_rank(machine, inside), machine) for machine, inside in self._reported(process)
        ]
        if having:
            return min(having)[1]
        machines = self._record.machines.items()
        return next((machine for machine, inside in machines if process in inside), "")

    def has_yielded(self, process: str, machine: str, lease: int) -> bool:
        """Whether a machine leaves a process to others from a lease on."""
        return all(
            inside.state == YIELDED and inside.lease >= lease
            for other, inside in self._reported(process)
            if other == machine
        )

    def state(self, process: str, machine: str) -> str:
        """Return the state of a process on a machine; empty if it has none of this name."""
        return next((one.state for name, one in self._reported(process) if name == machine), "")

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
