"""Configuration of supervisord for a swarm.

The file contains no path and no text of users, since supervisord expands and truncates its input.
Each command is in a file of its own, which a shell runs; the path of the socket is a variable.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from hitab_bringup.swarm_files.swarm_description import Process
from hitab_client.runs.run_processes import GROUP
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART, FINAL_AFTER
from hitab_ros.timing import FOUND_S

SOCKET_VARIABLE = "HITAB_SUPERVISOR_SOCKET"
"""Environment variable of supervisord with the path of its socket."""

COMMANDS_FOLDER = "commands"
"""Folder with the command of each process, in the run folder, where supervisord runs."""


def write_commands(processes: Sequence[Process], folder: Path) -> None:
    """Write the command of each process, for a shell, to a file with the process's name."""
    commands = folder / COMMANDS_FOLDER
    commands.mkdir(exist_ok=True)
    for process in processes:
        line = f"exec {shlex.join(process.command)}\n"
        (commands / process.name).write_text(line, encoding="utf-8")


def set_parameter(process: str, folder: Path, name: str, value: int) -> None:
    """Change a parameter in the command of a process."""
    file = folder / COMMANDS_FOLDER / process
    words = shlex.split(file.read_text(encoding="utf-8"))
    changed = (f"{name}:={value}" if word.startswith(f"{name}:=") else word for word in words)
    file.write_text(f"{shlex.join(changed)}\n", encoding="utf-8")


def supervisor_config(processes: Sequence[Process]) -> str:
    """Return the text of ``supervisord.conf``."""
    names = [process.name for process in processes]
    # One group, since supervisord stops groups one after the other.
    return f"""\
[unix_http_server]
file=%(ENV_{SOCKET_VARIABLE})s
chmod=0700

[supervisord]
nodaemon=true
logfile=supervisord.log
logfile_maxbytes=1MB

[rpcinterface:supervisor]
supervisor.rpcinterface_factory = supervisor.rpcinterface:make_main_rpcinterface
{"".join(map(program, names))}
[group:{GROUP}]
programs={",".join(names)}
"""


def program(name: str) -> str:
    """Return the section of a process.

    A process counts as started after startsecs. If it dies earlier, it is retried startretries
    times, each time after one more second. A process that dies later is restarted at once, unless
    its exit code shows that a restart would not help; such a process stays up for startsecs before
    exiting.
    """
    return f"""
[program:{name}]
command=/bin/sh {COMMANDS_FOLDER}/{name}
environment={FINAL_AFTER}="{FOUND_S:.0f}"
startsecs={FOUND_S:.0f}
startretries=12
exitcodes={DO_NOT_RESTART}
stopwaitsecs=5
stopasgroup=true
killasgroup=true
redirect_stderr=true
stdout_logfile=logs/{name}.log
stdout_logfile_maxbytes=1MB
stdout_logfile_backups=2
"""
