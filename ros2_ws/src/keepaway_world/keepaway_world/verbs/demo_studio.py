"""The studio beside the demo, in which training and playing can be watched."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import time
from collections.abc import Iterator

from hitab_bringup import RunningSwarm
from hitab_client import SwarmError, console

START_SECONDS = 20.0


@contextlib.contextmanager
def studio_beside(running: RunningSwarm, port: int, *, browser: bool) -> Iterator[None]:
    """Serve the studio for a swarm of this process, as long as this lasts.

    Raises:
        SwarmError: if it does not start, such as since the port is in use.
    """
    command = [sys.executable, "-m", "hitab_bringup.main", "studio", "--port", str(port)]
    command += ["--run-dir", str(running.folder.path), "--browser" if browser else "--no-browser"]
    process = subprocess.Popen(command, start_new_session=True)
    try:
        deadline = time.monotonic() + START_SECONDS
        node = running.link.node
        while node.count_subscribers("/world/state") < 2:  # this process watches too
            if process.poll() is not None or time.monotonic() > deadline:
                raise SwarmError("the studio did not start; see above")
            running.link.spin(0.05)
        yield
    finally:
        process.terminate()
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(10.0)


def play_on(running: RunningSwarm) -> None:
    """Let the trained keepers play in real time until the user has seen enough (Ctrl-C)."""
    running.world.control("pace", pace="realtime", factor=1.0)
    running.world.control("reset")
    running.world.control("resume")
    console.say("\nThe keepers play on; look at them in the studio. Ctrl-C ends it.")
    with contextlib.suppress(KeyboardInterrupt):
        while True:
            running.link.spin(0.5)
