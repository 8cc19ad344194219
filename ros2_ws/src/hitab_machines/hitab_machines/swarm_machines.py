"""The machines of a swarm for a person's program: who is there, and requests to them."""

from __future__ import annotations

import math
from typing import Any

from hitab_msgs.srv import ReadLog
from std_srvs.srv import Trigger

from hitab_client import MachineSigns, RosLink, RunRecord
from hitab_machines.process_holders import ProcessHolders
from hitab_ros import names
from hitab_ros.call import SwarmError
from hitab_ros.timing import DISCOVERY_S, FOUND_S, PROMPT_S, SETTLE_S, SILENT_AFTER_S


class SwarmMachines:
    """The machines of a swarm, as a program hears them.

    Args:
        link: the program's node.
        record: record of the run, of a swarm with machines.

    Attributes:
        holders: which machine has which process.
    """

    def __init__(self, link: RosLink, record: RunRecord) -> None:
        self.link = link
        self._process_of = {
            name: process for process, inside in record.processes.items() for name in inside
        }
        self.record = record
        self._signs = MachineSigns(link.node, record.namespace, record.identity)
        self.holders = ProcessHolders(self._signs, record)

    def listen(self) -> None:
        """Wait until all machines are heard, or would have been; longer for those others hear."""
        self.link.spin_until(lambda: not self._unheard(), SETTLE_S)
        self.link.spin_until(lambda: self._unheard().keys() <= self.silent().keys(), DISCOVERY_S)

    def heard_agents(self) -> list[str]:
        """Return the agents on machines that are heard, or would have been; see `listen`."""
        self.listen()
        silent = self.silent()
        return [name for name in self.record.agents if self.machine_of(name) not in silent]

    def silent(self) -> dict[str, float]:
        """Return the silent machines, with the time of silence, s; infinite if never heard.

        Of a machine that was silent before this program began, the others tell.
        """
        lasting = {name: age for name, age in self._unheard().items() if age > SILENT_AFTER_S}
        return {**lasting, **self._signs.silent()}

    def _unheard(self) -> dict[str, float]:
        """Return the machines that this program never heard, with their silence for others, s."""
        others = [link for status in self.holders.statuses().values() for link in status.links]
        return {
            name: min((link.age for link in others if link.machine == name), default=math.inf)
            for name in self.record.machines
            if name not in self._signs.heard
        }

    def machine_of(self, name: str) -> str:
        """Return the machine that has an agent, a commander, a process or the world."""
        return self.holders.holder(self._process_of.get(name, name))

    def elsewhere(self, name: str) -> str:
        """Return a text on the machine of an agent; empty if it is this one."""
        machine = self.machine_of(name)
        return f"  on {machine}" if machine != self.record.machine else ""

    def why_silent(self, machine: str) -> str:
        """Return how long a machine has been silent and the way out, without its name."""
        seconds, silent = self.silent().get(machine, 0.0), self.silent()
        said = f"has been silent for {seconds:.0f} s"
        if not math.isfinite(seconds):
            said = f"is not heard; start it there with `hitab up FILE --machine {machine}`"
        others = [name for name in self.record.machines if name not in silent]
        if others and self.holders.held_by(machine):
            said += f"; `hitab move {machine} --to {others[0]}` starts its agents there"
        return said

    def data(self) -> list[dict[str, Any]]:
        """Return the machines as plain data, the silent ones first."""
        silent, statuses, found = self.silent(), self.holders.statuses(), []
        for name in sorted(self.record.machines, key=lambda name: (name not in silent, name)):
            status = statuses.get(name)
            found.append(
                {
                    "machine": name,
                    "here": name == self.record.machine,
                    "silent": self.why_silent(name) if name in silent else None,
                    "processes": {p.name: p.state for p in status.processes} if status else {},
                    "faults": list(status.faults) if status else [],
                }
            )
        return found

    def faults(self) -> dict[str, list[str]]:
        """Return the machines that report each fault, by its text."""
        found: dict[str, list[str]] = {}
        for name, status in self.holders.statuses().items():
            for fault in status.faults if name not in self.silent() else ():
                found.setdefault(fault, []).append(name)
        return found

    def ask(self, machine: str, kind: Any, service: str, request: Any) -> Any:
        """Ask a machine for something; a short silence may be of signs that were lost.

        Raises:
            SwarmError: if it is silent, does not answer or refuses.
        """
        if self.silent().get(machine, 0.0) < DISCOVERY_S:
            self.link.spin_until(lambda: machine not in self.silent(), DISCOVERY_S)
        if machine in self.silent():
            raise SwarmError(f"{machine} {self.why_silent(machine)}")
        return self.link.call(
            kind,
            names.of_agent(machine, service, self.record.namespace),
            request,
            missing=lambda: SwarmError(f"the machine {machine} is heard, but does not answer"),
            where=machine,
        )

    def log(self, process: str, position: int, lines: int) -> tuple[list[str], int]:
        """Return lines of a process's log on its machine, and where to go on; see ReadLog.srv."""
        request = ReadLog.Request(process=process, position=position, lines=lines)
        answer = self.ask(self.machine_of(process), ReadLog, names.READ_LOG, request)
        return list(answer.lines), int(answer.position)

    def take_down(self, machine: str) -> None:
        """Take the part of the swarm on another machine down, and wait until it is.

        Raises:
            SwarmError: if the machine does not do it.
        """
        self.ask(machine, Trigger, names.TAKE_DOWN, Trigger.Request())
        if not self.link.spin_until(lambda: machine in self.silent(), FOUND_S + PROMPT_S):
            raise SwarmError(f"{machine} has not ended yet; look there with `hitab status`")
