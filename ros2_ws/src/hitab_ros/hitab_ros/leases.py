"""Leases: which host holds an agent that several hosts list, of a swarm on several machines.

A move of agents to another machine raises the number of their lease. All who hear the same rosters
agree on the holder, in whatever order these came, and no clocks are compared. Hosts without a
lease are of a swarm on one machine: no roster takes agents away from another host.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from hitab_msgs.msg import HostRoster, MachineProcess


@dataclass(frozen=True)
class Lease:
    """The lease under which a host runs its agents.

    Attributes:
        machine: the machine that the host runs on; empty in a swarm on one machine.
        number: number of the lease; 0 for none.
        process: name of the host's process in the swarm file, for people.
    """

    machine: str = ""
    number: int = 0
    process: str = ""

    @property
    def rank(self) -> tuple[int, str]:
        """Place among leases of the same agents: the one with the lowest rank has precedence."""
        return -self.number, self.machine

    def why_yield(self, other: HostRoster) -> str:
        """Return the sentence with which the host yields to another host of the same agents."""
        now = f"{self.process} runs on {other.machine} now (lease {other.lease})"
        return f"{now}; this one yields"


NO_LEASE = Lease()
YIELDED = "yielded"
"""State of a process that another machine has, under the lease that it reports."""


def rank(roster: HostRoster) -> tuple[tuple[int, str], int, str]:
    """Return the place of a roster among all: by its lease, then the latest start of a host."""
    return Lease(roster.machine, roster.lease).rank, -roster.number, roster.host


def machine_rank(machine: str, process: MachineProcess) -> tuple[bool, tuple[int, str]]:
    """Return the place of a machine among those that report a process: the first one has it."""
    return process.state == YIELDED, Lease(machine, process.lease).rank


def is_later(roster: HostRoster, known: HostRoster) -> bool:
    """Whether a roster replaces another one of the same host: by its start, whatever its lease.

    So a host takes back what somebody else has published in its name.
    """
    return (roster.number, roster.lease) > (known.number, known.lease)


def holders(rosters: Iterable[HostRoster]) -> list[HostRoster]:
    """Return the rosters, of those that list an agent, whose hosts hold it.

    It is one if any has a lease, else all, in the order of their ranks.
    """
    found = sorted(rosters, key=rank)
    return found[:1] if found and found[0].lease else found
