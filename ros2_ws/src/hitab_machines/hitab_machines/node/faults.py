"""What is wrong with a swarm's machines, as one of them hears the others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from hitab_msgs.msg import MachineStatus

from hitab_client import OFFSET_MAX_S, MachineSigns
from hitab_core import some
from hitab_machines.process_holders import running
from hitab_ros.timing import DISCOVERY_S, HEARTBEAT_S


class MachineFaults:
    """Finds the faults of a swarm's machines.

    Args:
        signs: the signs of the other machines.
        machine: name of this machine.
        machines: names of the machines in the swarm file.
    """

    def __init__(self, signs: MachineSigns, machine: str, machines: Sequence[str]) -> None:
        self._signs = signs
        self._machine = machine
        self._machines = machines

    def found(
        self,
        own: MachineStatus,
        up_s: float,
        differing: Mapping[int, str],
    ) -> Iterator[str]:
        """Yield a sentence for each fault.

        Args:
            own: the status of this machine.
            up_s: time since this machine began to listen, s.
            differing: names of the described files that differ, by the other process's number.
        """
        silent, heard = self._signs.silent(), self._signs.heard
        for name, seconds in sorted(silent.items()):
            yield silence(name, seconds, running(heard[name].status))
        for name in self._machines:
            if name not in heard and name != self._machine and up_s > DISCOVERY_S:
                yield (
                    f"{name} was not heard since {self._machine} started; start it there with "
                    f"`hitab up FILE --machine {name}`, or look there and here with `hitab doctor "
                    "--network 10`"
                )
        for name, machine in sorted(heard.items()):
            status = machine.status
            if name not in self._machines:
                yield f"{name} is not a machine of the swarm file; stop the swarm there"
                continue
            now = max(machine.processes.values())
            recent = sum(now - at < 2.0 * HEARTBEAT_S for at in machine.processes.values())
            is_own = name == self._machine
            if recent + (is_own and name not in silent) > 1:
                yield f"{name} was started twice; stop the swarm on one of the two computers"
            if is_own or name in silent:
                continue
            if status.version != own.version:
                yield (
                    f"{name} has HiTAB {status.version or 'of no version'}, {self._machine} "
                    f"{own.version}; install the same, and start it again"
                )
            what = differing.get(status.process, "")
            if what or status.description != own.description:
                what = what or "the swarm file, or a file that it names"
                yield (
                    f"{name} was started with other files: {what}; start it again with the files "
                    f"of {self._machine}"
                )
            if abs(machine.offset) > OFFSET_MAX_S:
                ahead = "ahead of" if machine.offset > 0 else "behind"
                yield (
                    f"the clock of {name} is {abs(machine.offset):.1f} s {ahead} that of "
                    f"{self._machine}: leases do not depend on it, but times in logs do, and a "
                    "commander that moves may be disregarded for as long; set it, such as by NTP"
                )


def silence(machine: str, seconds: float, processes: Sequence[str]) -> str:
    """Return a sentence on a silent machine."""
    runs = f", which runs {some(processes)}," if processes else ""
    return f"{machine}{runs} has been silent for {seconds:.0f} s"
