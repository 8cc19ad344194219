"""The configuration of supervisord for a swarm."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from hitab_bringup.swarm_description import Process
from hitab_ros.exit_codes import FINAL, FINAL_AFTER

START_SECONDS = 3


def supervisor_config(processes: Sequence[Process], folder: Path, socket: Path) -> str:
    """Return the text of ``supervisord.conf``."""
    programs = "".join(_program(process, _plain(folder)) for process in processes)
    # One group, since groups are stopped one after the other.
    return f"""\
[unix_http_server]
file={_plain(socket)}
chmod=0700

[supervisord]
nodaemon=true
logfile={_plain(folder)}/supervisord.log
logfile_maxbytes=1MB

[rpcinterface:supervisor]
supervisor.rpcinterface_factory = supervisor.rpcinterface:make_main_rpcinterface
{programs}
[group:swarm]
programs={",".join(process.name for process in processes)}
"""


def _program(process: Process, folder: str) -> str:
    """Return the section of a process.

    It counts as started after startsecs. If it dies earlier, it is retried startretries times,
    each time after one more second. If it dies later, it is restarted at once, unless its exit
    code says that a restart would not help; such a process stays up for startsecs before it exits.
    """
    return f"""
[program:{process.name}]
command={_plain(shlex.join(process.command))}
directory={folder}
environment={FINAL_AFTER}="{START_SECONDS}"
startsecs={START_SECONDS}
startretries=12
exitcodes={FINAL}
stopwaitsecs=5
stopasgroup=true
killasgroup=true
redirect_stderr=true
stdout_logfile={folder}/logs/{process.name}.log
stdout_logfile_maxbytes=1MB
stdout_logfile_backups=2
"""


def _plain(text: object) -> str:
    """Escape characters that supervisord would expand."""
    return str(text).replace("%", "%%")
