"""Checks of runs: swarms that are up, faults of agents, and leftovers of killed runs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from hitab_bringup.doctor.finding import WARNING, Finding, judged
from hitab_client import RunRecord, SwarmError
from hitab_client.runs.run_folder import (
    RunFolder,
    marked_processes,
    registered_swarms,
    running_swarms,
)
from hitab_client.runs.run_processes import is_suspended, process_states
from hitab_client.runs.swarm_choice import way_to_stop
from hitab_client.terminal.cli_remedies import as_command
from hitab_core import Fix, each_once, quantity, some
from hitab_ros.timing import DISCOVERY_S, FOUND_S

PROCESSES_NAMED_MAX = 5  # maximum number of processes listed by name
LARGE_SWARM = 100  # number of agents above which requests take long


def swarms() -> Iterator[Finding]:
    """Report the swarms that are up or have crashed."""
    found = [finding for run in registered_swarms() for finding in _run(*run)]
    yield from found or [Finding("swarm", f"none is up; {as_command(Fix.UP(swarm='keepaway'))}")]


def _run(folder: RunFolder, record: RunRecord) -> Iterator[Finding]:
    stop = as_command(way_to_stop(folder, record))
    if folder.supervisor(record) is None:
        text = f"{record.swarm} has ended without being stopped ({folder.path})"
        yield Finding("swarm", text, WARNING, stop)
        return
    try:
        states = process_states(record, DISCOVERY_S)
    except SwarmError as error:
        yield Finding("swarm", error.problem, WARNING, stop)
        return
    running = [state for state in states if state["statename"] == "RUNNING"]
    lost = [state["name"] for state in states if state not in running]
    pids = some([f"{state['name']} {state['pid']}" for state in running], PROCESSES_NAMED_MAX)
    where = f"in ROS domain {record.domain_id}, supervisor {record.supervisor}"
    text = f"{record.swarm} is up {where}: {pids}"
    text += f"; {', '.join(lost[:PROCESSES_NAMED_MAX])} does not run" if lost else ""
    yield judged("swarm", text, not lost, as_command(Fix.LOGS(node=lost[0] if lost else "")))
    for state in running:
        if is_suspended(state["pid"]):
            text = f"{state['name']} of {record.swarm} is suspended (process {state['pid']})"
            way_out = f"`kill -CONT {state['pid']}` lets it continue"
            yield Finding("swarm", text, WARNING, way_out)


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
        numbers = some([str(pid) for pid in sorted(pids)], PROCESSES_NAMED_MAX)
        unknown = "" if mark in known else ", which no command knows"
        text = f"processes {numbers} of a killed run in {mark}{unknown}"
        yield Finding("leftovers", text, WARNING, as_command(Fix.DOWN_FOLDER(folder=mark)))
    if not lost:
        yield Finding("leftovers", "no processes of killed runs")


def faults() -> Iterator[Finding]:
    """Report the faults of agents, such as a silent sensor."""
    for _, record in running_swarms():
        if len(record.agents) > LARGE_SWARM:
            count = quantity(len(record.agents), "agent")
            text = f"the {count} of {record.swarm} were not asked; {as_command(Fix.STATUS())}"
            yield Finding("agents", text)
        else:
            yield from _faults_of(record)


def _faults_of(record: RunRecord) -> Iterator[Finding]:
    from hitab_client import RosLink, SwarmClient

    with RosLink(record.domain_id) as link:
        agents = SwarmClient(
            link, record.agents, prefix=record.namespace, identity=record.identity
        )
        link.spin_until(lambda: len(agents.statuses) == len(record.agents), FOUND_S)
        statuses = dict(agents.statuses)
    mute = [name for name in record.agents if name not in statuses]
    if mute:
        text = f"{some(mute)} of {record.swarm} did not answer within {FOUND_S:g} s"
        yield Finding("agents", text, WARNING, as_command(Fix.LOGS(node=mute[0])))
    found = each_once((name, fault) for name, s in statuses.items() for fault in s.faults)
    yield from (Finding("agents", fault, WARNING, as_command(Fix.STATUS())) for fault in found)
    if not mute and not found:
        yield Finding("agents", f"{quantity(len(statuses), 'agent')} of {record.swarm}: no faults")
