"""Checks the runs: what is up, and what killed runs have left behind."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hitab_bringup.doctor.finding import Finding, warning
from hitab_client import SwarmError
from hitab_client.commands import as_command
from hitab_client.run_folder import RunFolder, marked_processes, registered_swarms
from hitab_client.run_processes import ANSWER_SECONDS, is_suspended, process_states
from hitab_client.swarm_choice import way_to_stop
from hitab_core import Do, some

SHOWN = 5  # processes by name


def swarms() -> Iterator[Finding]:
    """Report the swarms that are up or have crashed."""
    up = False
    for folder, record in registered_swarms():
        up = True
        if folder.supervisor(record) is None:
            yield warning(
                "swarm",
                f"{record.swarm} has ended without being stopped ({folder.path})",
                as_command(way_to_stop(folder, record)),
            )
            continue
        where = f"in ROS domain {record.domain_id}, supervisor {record.supervisor}"
        try:
            states = process_states(record, ANSWER_SECONDS)
        except SwarmError as error:
            yield warning("swarm", error.problem, as_command(way_to_stop(folder, record)))
            continue
        running = [state for state in states if state["statename"] == "RUNNING"]
        pids = some([f"{state['name']} {state['pid']}" for state in running], SHOWN)
        told = f"{record.swarm} is up {where}: {pids}"
        if lost := [state["name"] for state in states if state not in running]:
            yield warning(
                "swarm",
                f"{told}; {', '.join(lost[:SHOWN])} does not run",
                as_command(Do.LOGS(node=lost[0])),
            )
        else:
            yield Finding("swarm", told)
        for state in running:
            if is_suspended(state["pid"]):
                yield warning(
                    "swarm",
                    f"{state['name']} of {record.swarm} is suspended (process {state['pid']})",
                    f"`kill -CONT {state['pid']}` lets it continue",
                )
    if not up:
        yield Finding("swarm", f"none is up; {as_command(Do.UP(swarm='keepaway'))}")


def leftovers() -> Iterator[Finding]:
    """Report the processes of runs that have no supervisor."""
    known = {str(folder.path) for folder, _ in registered_swarms()}
    lost: dict[str, list[int]] = {}
    for process, mark in marked_processes():
        folder = RunFolder(Path(mark))
        record = folder.read()
        if record is None or folder.supervisor(record) is None:
            lost.setdefault(mark, []).append(process.pid)
    for mark, pids in sorted(lost.items()):
        numbers = some([str(pid) for pid in sorted(pids)], SHOWN)
        yield warning(
            "leftovers",
            f"processes {numbers} of a killed run in {mark}"
            + ("" if mark in known else ", which no command knows"),
            as_command(Do.DOWN_FOLDER(folder=mark)),
        )
    if not lost:
        yield Finding("leftovers", "no processes of killed runs")
