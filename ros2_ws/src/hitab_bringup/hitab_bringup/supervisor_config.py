"""The configuration of supervisord for a swarm."""

from __future__ import annotations

import shlex
from collections.abc import Iterable
from pathlib import Path

from hitab_bringup.swarm_processes import Process
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
logfile_backups=1
pidfile={folder}/supervisord.pid
childlogdir={folder}/logs

[rpcinterface:supervisor]
supervisor.rpcinterface_factory = supervisor.rpcinterface:make_main_rpcinterface
"""

# A process counts as started once it has lived for startsecs; one that dies earlier is tried
# again startretries times, each a second later than the one before; one that dies later is
# restarted at once, unless its exit code says that this would not help: such a process lives
# that long.
PROGRAM = """
[program:{name}]
command={command}
directory={folder}
environment={final_after}="{start_seconds}"
startsecs={start_seconds}
startretries=12
autorestart=unexpected
exitcodes={final}
stopsignal=TERM
stopwaitsecs=5
stopasgroup=true
killasgroup=true
redirect_stderr=true
stdout_logfile={log}
stdout_logfile_maxbytes=1MB
stdout_logfile_backups=2
"""

# In one group, since groups are stopped one after the other.
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
    """Escape what supervisord would expand."""
    return str(text).replace("%", "%%")
