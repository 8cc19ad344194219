"""Distribution of a swarm's members and processes to its machines.

A name under `runs:` refers to the world, a line, a single member, or a commander with all that it
commands. The nearest name decides: the member's, its line's, then that of the nearest commander
above. Everything else runs on the first machine, but a process in the namespace of an agent runs
beside that agent.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from hitab_bringup.swarm_files.commander_tree import in_hosts
from hitab_bringup.swarm_files.swarm_description import (
    AgentDescription,
    CommanderDescription,
    MachineDescription,
)
from hitab_bringup.swarm_files.swarm_lines import SwarmLines
from hitab_core import has, some
from hitab_core.library.yaml_places import Complaints
from hitab_ros.names import WORLD

Member = TypeVar("Member", bound=AgentDescription)


class MachinePlan:
    """Assigns members and processes to machines, and reports every fault of their lines.

    Args:
        file: the swarm file.
        groups: agents and commanders, by the key of their line.
        complaints: gets the faults.
    """

    def __init__(
        self,
        file: SwarmLines,
        groups: Mapping[str, Sequence[AgentDescription]],
        complaints: Complaints,
    ) -> None:
        self._file, self._complaints = file, complaints
        self._members = {member.name: member for group in groups.values() for member in group}
        self._key = {member.name: key for key, group in groups.items() for member in group}
        self._beside = {key: line.namespace for key, line in file.processes.items()}
        if file.world is not None:
            self._beside[WORLD] = ""
        self._named: dict[str, str] = {}
        if file.machines:
            self._take_names({*groups, *self._members, *self._beside})
            self._check_paths()

    def _tell(self, machine: str, key: str, text: str) -> None:
        self._complaints.add(("machines", machine, key), text)

    def _take_names(self, known: set[str]) -> None:
        for machine, line in self._file.machines.items():
            for name in line.runs:
                other = self._named.setdefault(name, machine)
                if name not in known:
                    text = f'`runs:` there is no agent, commander or process "{name}" '
                    self._tell(machine, "runs", text + has(known, name))
                elif other != machine:
                    text = f'`runs:` "{name}" also runs on "{other}"; remove it from one of them'
                    self._tell(machine, "runs", text)
            machines = self._file.machines
            others = machines.keys() - {machine}
            if len(others) == 1 and line.takes_over and machines[min(others)].takes_over:
                text = (
                    "`takes_over:` of two machines that take over from each other, each would "
                    "after a cut; remove it from one of them, or add a third machine"
                )
                self._tell(machine, "takes_over", text)
            for name in (name for name in line.takes_over if name not in others):
                text = f'`takes_over:` there is no other machine "{name}" {has(others, name)}'
                self._tell(machine, "takes_over", text)

    def _check_paths(self) -> None:
        """Complain about folders and files that other machines cannot have."""
        file = self._file
        for place, line in (
            ((), file),
            *((("agents", key), one) for key, one in file.agents.items()),
            *((("commanders", key), one) for key, one in file.commanders.items()),
        ):
            if line.library:
                text = (
                    "`library:` each machine keeps the libraries of its agents in its run folder; "
                    "write `start_from:` instead"
                )
                self._complaints.add((*place, "library"), text)
            self._check_path((*place, "start_from"), line.start_from)
        for name, kind in file.kinds.items():
            if isinstance(kind, str):
                self._check_path(("kinds", name), kind)

    def _check_path(self, place: tuple[str, ...], path: str) -> None:
        if Path(path).is_absolute():
            text = (
                f'`{place[-1]}:` "{path}" is on this machine only; write a path relative to this '
                "file, from which the other machines get it"
            )
            self._complaints.add(place, text)

    def _machine_of(self, name: str) -> str:
        """Return the machine of a member, a further process or the world."""
        for known in (name, self._key.get(name, "")):
            if known in self._named:
                return self._named[known]
        above = self._members[name].superior if name in self._members else self._beside[name]
        first = next(iter(self._file.machines))
        return self._machine_of(above) if above in self._members else first

    def placed(
        self, agents: Sequence[AgentDescription], commanders: Sequence[CommanderDescription]
    ) -> tuple[list[AgentDescription], list[CommanderDescription]]:
        """Return the members, each with the name of its process."""
        hosted_agents: dict[str, AgentDescription] = {}
        hosted_commanders: dict[str, CommanderDescription] = {}
        for machine, line in self._file.machines.items():

            def here(members: Sequence[Member], machine: str = machine) -> list[Member]:
                mine = (m for m in members if self._machine_of(m.name) == machine)
                return [member for member in mine if not member.process]

            hosts = line.hosts or self._file.hosts or 1
            ours, theirs = in_hosts(here(agents), here(commanders), hosts, f"{machine}_")
            hosted_agents |= {agent.name: agent for agent in ours}
            hosted_commanders |= {commander.name: commander for commander in theirs}
        return (
            [hosted_agents.get(agent.name, agent) for agent in agents],
            [hosted_commanders.get(commander.name, commander) for commander in commanders],
        )

    def machines(self, members: Sequence[AgentDescription]) -> Iterator[MachineDescription]:
        """Yield the machines, each with the processes of placed members, and with the others."""
        if not self._file.machines:
            return
        inside: dict[str, dict[str, list[str]]] = {}
        for member in members:
            machines = inside.setdefault(member.process, {})
            machines.setdefault(self._machine_of(member.name), []).append(member.name)
        for process, found in inside.items():
            if len(found) > 1:
                where = " and ".join(f'{some(names)} on "{m}"' for m, names in found.items())
                text = (
                    f'`runs:` process "{process}" would run {where}; name whole lines, or give '
                    "the members on each machine a `host:` of their own"
                )
                self._tell([*found][-1], "runs", text)
        placed = {process: next(iter(found)) for process, found in inside.items()}
        placed |= {name: self._machine_of(name) for name in self._beside}
        for name, line in self._file.machines.items():
            processes = tuple(process for process, machine in placed.items() if machine == name)
            if not processes:
                text = "runs nothing: name a line, a member or a process under `runs:`"
                self._complaints.add(("machines", name), text)
            yield MachineDescription(name, processes, line.ssh, line.hitab, line.takes_over)
