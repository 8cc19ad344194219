"""The `hitab` command in a process of its own that does not begin with a second of imports.

Tests and pages run hundreds of commands. Each is run by a fork of a process that has imported what
all of them use.
"""

from __future__ import annotations

import faulthandler
import multiprocessing
import os
import shlex
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

IMPORTED = [
    "hitab_cli.main",
    "hitab_cli.verbs.verb_connection",
    "hitab_client.connecting.ros_link",
    "hitab_client.swarm_client",
    "hitab_client.runs.swarm_choice",
    "hitab_client.world_client",
    "hitab_core.library.behavior_library",
    "rclpy",
    "rich.table",
    "rosidl_generator_py",
    "std_msgs.msg",
    "typer._adapters",
]

_fork = multiprocessing.get_context("forkserver")
_fork.set_forkserver_preload(IMPORTED)


def run(
    words: Sequence[str], folder: Path, environment: Mapping[str, str], seconds: float
) -> tuple[int, str, str]:
    """Run a command.

    Args:
        words: its command line, which begins with `hitab`.
        folder: to run it in.
        environment: its environment variables.
        seconds: the longest that it may take.

    Returns:
        Its exit status, and what it printed to stdout and stderr.

    Raises:
        TimeoutError: if it takes longer.
    """
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        files = [f"/proc/{os.getpid()}/fd/{file.fileno()}" for file in (out, err)]
        process = _fork.Process(
            target=_hitab, args=(words, folder, dict(environment), files, 0.9 * seconds)
        )
        process.start()
        process.join(seconds)
        if process.exitcode is None:
            process.kill()
            process.join()
            err.seek(0)
            said = err.read().decode()
            raise TimeoutError(f"{shlex.join(words)} takes longer than {seconds:g} s:\n{said}")
        out.seek(0)
        err.seek(0)
        return process.exitcode, out.read().decode(), err.read().decode()


def _hitab(
    words: Sequence[str],
    folder: Path,
    environment: dict[str, str],
    files: Sequence[str],
    seconds: float,
) -> None:
    for there, here in zip(files, (1, 2), strict=True):
        file = os.open(there, os.O_WRONLY)
        os.dup2(file, here)
        os.close(file)
    # Where it hangs, should it take too long.
    faulthandler.dump_traceback_later(seconds, file=2)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    # As a new interpreter would.
    sys.path[:0] = filter(None, environment.get("PYTHONPATH", "").split(os.pathsep))
    sys.argv = list(words)
    from hitab_cli.main import main

    main()
