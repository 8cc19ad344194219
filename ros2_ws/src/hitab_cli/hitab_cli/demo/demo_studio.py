"""The studio for watching the demo."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator

from hitab_bringup import RunningSwarm
from hitab_client import SwarmError, console
from hitab_ros.timing import START_S


@contextlib.contextmanager
def studio_beside(running: RunningSwarm, port: int, *, browser: bool) -> Iterator[None]:
    """Serve the studio for a swarm of this process, for the duration of the context.

    Raises:
        SwarmError: if it does not start, for example because the port is in use.
    """
    command = [sys.executable, "-m", "hitab_cli.main", "studio", "--port", str(port)]
    command += ["--run-dir", str(running.folder.path), "--browser" if browser else "--no-browser"]
    process = subprocess.Popen(command, start_new_session=True)
    try:
        deadline = time.monotonic() + START_S
        node = running.link.node
        while node.count_subscribers("/world/state") < 2:  # this process watches too
            if process.poll() is not None or time.monotonic() > deadline:
                raise SwarmError("the studio did not start; see its error above")
            running.link.spin(0.05)
        yield
    finally:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(10.0)


def play_on(running: RunningSwarm) -> None:
    """Let the trained agents play in real time until Ctrl-C."""
    running.world.control("pace", pace="realtime", factor=1.0)
    running.world.control("reset")
    running.world.control("resume")
    console.say("\nThe agents keep playing; watch them in the studio. Ctrl-C ends it.")
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            running.link.spin(0.5)
