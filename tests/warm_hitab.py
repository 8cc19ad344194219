"""The `hitab` command in a process of its own that does not begin with a second of imports.

Pages have dozens of commands. Each of these is run by a fork of a process that has imported what
all of them use.
"""

from __future__ import annotations

import multiprocessing
import os
import shlex
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

IMPORTED = [
    "hitab_bringup.main",
    "hitab_bringup.verbs.connection",
    "hitab_client.ros_link",
    "hitab_client.swarm_client",
    "hitab_client.swarm_choice",
    "hitab_client.world_client",
    "hitab_core.library.behavior_library",
    "rclpy",
    "rich.table",
]

_fork = multiprocessing.get_context("forkserver")
_fork.set_forkserver_preload(IMPORTED)


def run(
    command: str, folder: Path, environment: Mapping[str, str], seconds: float
) -> tuple[int, str, str]:
    """Run a command line that begins with `hitab`.

    Returns:
        Its exit status, and what it printed to stdout and stderr.
    """
    words = shlex.split(command, comments=True)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = _fork.Process(
            target=_hitab,
            args=(words, folder, dict(environment), out.fileno(), err.fileno(), os.getpid()),
        )
        process.start()
        process.join(seconds)
        if process.exitcode is None:
            process.kill()
            process.join()
            raise TimeoutError(f"{command} takes longer than {seconds:g} s")
        out.seek(0)
        err.seek(0)
        return process.exitcode, out.read().decode(), err.read().decode()


def _hitab(
    words: list[str], folder: Path, environment: dict[str, str], out: int, err: int, parent: int
) -> None:
    for there, here in ((out, 1), (err, 2)):
        file = os.open(f"/proc/{parent}/fd/{there}", os.O_WRONLY)
        os.dup2(file, here)
        os.close(file)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = words
    from hitab_bringup.main import main

    main()
