"""Moves of agents to another machine, by whole processes."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

from hitab_msgs.srv import RunProcess

from hitab_bringup import read_swarm
from hitab_core import has, some
from hitab_machines.swarm_machines import SwarmMachines
from hitab_ros import names
from hitab_ros.call import SwarmError
from hitab_ros.timing import POLL_S

Progress = Callable[[int, int, str], None]
"""Called with the number of moved processes, of all, and the names of the others."""


@dataclass
class Move:
    """What came of the move of a process: what was done, what is lost, or the error."""

    process: str
    lease: int
    message: str = ""
    lost: list[str] = field(default_factory=list)
    error: str = ""


def processes_meant(group: str, machines: SwarmMachines) -> list[str]:
    """Return the processes that are meant: those of a machine, an agent, a line, or a commander.

    Raises:
        SwarmError: if there is none of this name, or a process runs others as well.
    """
    record = machines.record
    if group in record.machines:
        if held := machines.holders.held_by(group):
            return held
        raise SwarmError(f"{group} has no agents; look with `hitab status`")
    if group in record.processes:
        return [group]
    agents = _agents_meant(group, machines)
    meant = {name: {*inside} for name, inside in record.processes.items() if agents & {*inside}}
    for process, inside in meant.items():
        if others := sorted(inside - agents):
            raise SwarmError(
                f"{process}, which runs {some(sorted(inside & agents))}, runs {some(others)} as "
                f"well; move {process}, or give them another `host:` in the swarm file"
            )
    if not meant:
        known = (*record.agents, *record.processes, *record.machines)
        raise SwarmError(f'no agent, process or machine "{group}" {has(known, group)}')
    return list(meant)


def _agents_meant(group: str, machines: SwarmMachines) -> set[str]:
    record = machines.record
    if group in record.commanders:
        commanders = read_swarm(Path(record.description)).commanders
        below = {commander.name: [*commander.subordinates] for commander in commanders}

        def with_all_below(name: str) -> Iterator[str]:
            yield name
            for subordinate in below.get(name, ()):
                yield from with_all_below(subordinate)

        return {*with_all_below(group)}
    line = re.compile(rf"{re.escape(group)}(_\d+)?")
    return {name for name in record.agents if line.fullmatch(name)}


def move(processes: list[str], to: str, machines: SwarmMachines, progress: Progress) -> list[Move]:
    """Move processes to a machine, and wait until all agents run there.

    Args:
        processes: names of the processes.
        to: name of the machine.
        machines: the machines.
        progress: called whenever a process is up.

    Raises:
        SwarmError: if there is no such machine, or it is silent.
    """
    record = machines.record
    if to not in record.machines:
        raise SwarmError(f'no machine "{to}" {has(record.machines, to)}')
    moves = [Move(process, machines.holders.newest_lease(process) + 1) for process in processes]
    while pending := [one for one in moves if not (one.message or one.error)]:
        for one in pending:
            request = RunProcess.Request(process=one.process, lease=one.lease)
            try:
                answer = machines.ask(to, RunProcess, names.RUN_PROCESS, request)
                one.message, one.lost = answer.message, list(answer.lost)
            except SwarmError as error:
                one.error = error.problem
        left = [one.process for one in moves if not (one.message or one.error)]
        progress(len(moves) - len(left), len(moves), some(left) if left else "")
        if left:
            machines.link.spin_until(lambda: False, POLL_S)
    return moves
