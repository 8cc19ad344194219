"""The configuration of supervisord for a swarm."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from pathlib import Path

from hitab_bringup.swarm_description import Process
from hitab_ros.exit_codes import FINAL, FINAL_AFTER

START_SECONDS = 3

HEAD = """\
[unix_http_server]
file={socket}
chmod=0700

[supervisord]
nodaemon=true
logfile={folder}/supervisord.log
logfile_maxbytes=1MB

[rpcinterface:supervisor]
supervisor.rpcinterface_factory = supervisor.rpcinterface:make_main_rpcinterface
"""

# A process counts as started after startsecs. If it dies earlier, it is retried startretries
# times, each time after one more second. If it dies later, it is restarted at once, unless its
# exit code says that a restart would not help; such a process stays up for startsecs before it
# exits.
PROGRAM = """
[program:{name}]
command={command}
directory={folder}
environment={final_after}="{start_seconds}"
startsecs={start_seconds}
startretries=12
exitcodes={final}
stopwaitsecs=5
stopasgroup=true
killasgroup=true
redirect_stderr=true
stdout_logfile={log}
stdout_logfile_maxbytes=1MB
stdout_logfile_backups=2
"""

# One group, since groups are stopped one after the other.
GROUP = """
[group:swarm]
programs={names}
"""


def supervisor_config(processes: Iterable[Process], folder: Path, logs: Path, socket: Path) -> str:
    """Return the text of ``supervisord.conf``."""
    parts = [HEAD.format(socket=_plain(socket), folder=_plain(folder))]
    names = []
    for process in processes:
        names.append(process.name)
        parts.append(
            PROGRAM.format(
                name=process.name,
                command=_plain(shlex.join(process.command)),
                folder=_plain(folder),
                log=_plain(logs / f"{process.name}.log"),
                final=FINAL,
                final_after=FINAL_AFTER,
                start_seconds=START_SECONDS,
            )
        )
    parts.append(GROUP.format(names=",".join(names)))
    return "".join(parts)


def _plain(text: object) -> str:
    """Escape characters that supervisord would expand."""
    return str(text).replace("%", "%%")
