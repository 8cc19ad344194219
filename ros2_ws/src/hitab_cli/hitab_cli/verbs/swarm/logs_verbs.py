"""Verb that shows the logs of a swarm's processes: logs."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from hitab_client import SwarmError, completion, console
from hitab_client.terminal.cli_options import SwarmName
from hitab_core import Fix, has
from hitab_ros.timing import POLL_S

if TYPE_CHECKING:
    from collections.abc import Iterable

    from hitab_bringup import LogFile, LogLine
    from hitab_client import RunFolder, RunRecord

Level = Literal["debug", "info", "warn", "error", "fatal"]


def logs(
    name: Annotated[str, typer.Argument(autocompletion=completion.processes)] = "",
    follow: Annotated[bool, typer.Option("--follow", "-f")] = False,
    lines: Annotated[int, typer.Option("--lines", "-n", min=0)] = 100,
    level: Annotated[Level, typer.Option(metavar="LEVEL", show_default=False)] = "debug",
    swarm: SwarmName = None,
) -> None:
    """Show the logs of a swarm's processes, even after the swarm has ended.

    Of a swarm on several machines, a named log is also shown from another machine.

    Args:
        name: An agent, a host, a machine, world or supervisor. Default: all of this machine.
        follow: Continue until the swarm is down, or Ctrl-C.
        lines: Number of lines to begin with; 0 for all.
        level: Only lines of this level or above: debug, info, warn, error or fatal.

    Examples:
      hitab logs
      hitab logs keeper_1 --follow
      hitab logs lab_2
      hitab logs --level warn
    """
    from hitab_bringup import logs_of, new_lines

    folder, record = _run(swarm)
    if _shown_from_elsewhere(name, folder, record, lines, level, follow):
        return
    files = _chosen(name, folder, record)
    console.note(f"from {files[0].path if len(files) == 1 else folder.path / 'logs'}")
    names = len(files) > 1
    last = new_lines(files, level, ended=follow)
    if not last:
        console.note(f"no lines{f' of level {level} or above' if level != 'debug' else ''}")
    _say(last[-lines:], names)
    while follow:
        record = folder.read()
        up = record is not None and folder.supervisor(record) is not None
        if names:  # processes may have been added
            known = {file.path for file in files}
            files += [file for file in logs_of(folder) if file.path not in known]
        _say(new_lines(files, level, ended=True), names)
        if not up:
            console.note(f"{folder.path.name} is down")
            return
        time.sleep(POLL_S)


def _shown_from_elsewhere(
    name: str, folder: RunFolder, record: RunRecord | None, count: int, level: Level, follow: bool
) -> bool:
    """Show the log of a process on another machine; return whether it is on another one."""
    if not (name and record and record.machines and folder.supervisor(record)):
        return False
    from hitab_bringup import LogFile
    from hitab_client import RosLink
    from hitab_client.runs.run_processes import RunProcesses
    from hitab_machines import SwarmMachines

    with RosLink(record.domain_id) as link:
        machines = SwarmMachines(link, record)
        machines.listen()
        process, machine = RunProcesses(record).process_of(name), machines.machine_of(name)
        if machine in ("", record.machine):
            return False
        console.note(f"from {machine}")
        file = LogFile(process, Path(process))
        lines, position = machines.log(process, 0, count or 2**32 - 1)
        while True:
            _say(file.parsed(lines, level), names=False)
            if not follow:
                return True
            link.spin_until(lambda: False, POLL_S)
            lines, position = machines.log(process, position, 2**32 - 1)


def _say(lines: Iterable[LogLine], names: bool) -> None:
    for line in lines:
        console.say(f"{line.process} | {line.text}" if names else line.text)


def _run(swarm: str | None) -> tuple[RunFolder, RunRecord | None]:
    """Return the chosen run: the swarm that is up, else the last one.

    Raises:
        SwarmError: if there is no run, or the choice is ambiguous.
    """
    from hitab_client import RunFolder
    from hitab_client.runs.run_folder import state_home
    from hitab_client.runs.swarm_choice import find_running, folder_called

    if swarm is not None:
        folder = folder_called(swarm)
        if (folder.path / "logs").is_dir():
            return folder, folder.read()
    found = find_running(swarm)
    if found is not None:
        return found
    ended = [path.parent for path in state_home().glob("*/logs") if path.is_dir()]
    if not ended:
        raise SwarmError(f"no swarm has run under {state_home()}", Fix.UP(swarm="keepaway"))
    newest = max(ended, key=lambda path: (path / "logs").stat().st_mtime)
    console.note(f"{newest.name} is down; these are the logs of its last run")
    folder = RunFolder(newest)
    return folder, folder.read()


def _chosen(name: str, folder: RunFolder, record: RunRecord | None) -> list[LogFile]:
    from hitab_bringup import logs_of
    from hitab_client.runs.run_processes import RunProcesses

    files = logs_of(folder)
    if not name:
        if not files:
            raise SwarmError(f"{folder.path} has no logs")
        return files
    process = RunProcesses(record).process_of(name)
    for file in files:
        if file.process == process:
            return [file]
    known = {file.process for file in files} | set(record.agents if record is not None else ())
    raise SwarmError(f'nothing called "{name}" ran here {has(known, name)}')
