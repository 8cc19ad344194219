"""Start of a swarm's other machines from this one, by the system's `ssh`."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from types import TracebackType
from typing import Self

from hitab_bringup import MachineDescription, SwarmDescription
from hitab_client import SwarmError
from hitab_client.connecting.dds_profile import RANGE
from hitab_core import some
from hitab_ros.timing import ANSWER_S

PASSED = (RANGE, "ROS_STATIC_PEERS", "ROS_DISCOVERY_SERVER", "RMW_IMPLEMENTATION")
"""Variables that the machines of a swarm must have in common."""

SSH_FAILED, NOT_EXECUTABLE, NOT_FOUND = 255, 126, 127
CTRL_C = b"\x03"


def local_machine(swarm: SwarmDescription) -> str:
    """Return the machine of a swarm that is this one if the user names none: without `ssh:`.

    Raises:
        SwarmError: if there is none, or several.
    """
    if not swarm.machines:
        raise SwarmError(f"{swarm.file} has no `machines:`; leave out --all")
    own = [machine.name for machine in swarm.machines if not machine.ssh]
    if len(own) != 1:
        why = f"{some(own)} have no `ssh:`" if own else "every machine has `ssh:`"
        raise SwarmError(f"{swarm.file}: {why}; say which this one is with --machine NAME")
    return own[0]


class RemoteStarts:
    """Starts the other machines of a swarm; a context manager that interrupts them on errors.

    Args:
        swarm: the description, with this machine.
        name: the swarm's name, by which the others get its description from here.
        domain_id: ROS domain of the swarm.
        options: options of `hitab up` for all machines.
        say: called with each line of the others, from other threads.

    Raises:
        SwarmError: if there is no `ssh`, or a machine has no `ssh:`.
    """

    def __init__(
        self,
        swarm: SwarmDescription,
        name: str,
        domain_id: int,
        options: Sequence[str],
        say: Callable[[str], None],
    ) -> None:
        others = [machine for machine in swarm.machines if machine.name != swarm.machine]
        if closed := [machine.name for machine in others if not machine.ssh]:
            raise SwarmError(
                f"{swarm.file}: {some(closed)} cannot be started from here; add `ssh:`, or start "
                "each machine on its computer with --machine NAME"
            )
        if shutil.which("ssh") is None:
            raise SwarmError(
                "there is no program `ssh` on the PATH; install an OpenSSH client, or start each "
                "machine on its computer with --machine NAME"
            )
        variables = {name: os.environ[name] for name in PASSED if os.environ.get(name)}
        variables["ROS_DOMAIN_ID"] = str(domain_id)
        self._starts = [
            _RemoteStart(machine, ["up", name, *options], variables, say) for machine in others
        ]

    def __enter__(self) -> Self:
        for start in self._starts:
            start.begin()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: object, trace: TracebackType | None
    ) -> None:
        if kind is not None:
            for start in self._starts:
                start.interrupt()
            for start in self._starts:
                start.end(ANSWER_S)

    def wait(self) -> list[str]:
        """Wait until all have started; return a sentence for each machine that is not up."""
        return [text for start in self._starts if (text := start.failure())]


class _RemoteStart:
    """The start of one machine."""

    def __init__(
        self,
        machine: MachineDescription,
        arguments: Sequence[str],
        variables: Mapping[str, str],
        say: Callable[[str], None],
    ) -> None:
        self._machine, self._say = machine, say
        settings = [shlex.quote(f"{key}={value}") for key, value in variables.items()]
        hitab = [machine.hitab, *map(shlex.quote, arguments), "--machine", machine.name]
        remote = ["env", "TERM=dumb", *settings, *hitab]  # a bar would fill the lines
        # A terminal there passes Ctrl-C on, and ends `hitab up` if the connection breaks.
        # ssh itself speaks only of errors, and not of the end of the connection.
        options = ["-tt", "-o", "BatchMode=yes", "-o", "LogLevel=ERROR"]
        self._command = ["ssh", *options, machine.ssh, " ".join(remote)]
        self._last = ""

    def begin(self) -> None:
        self._process = subprocess.Popen(
            self._command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,  # the terminal's Ctrl-C is passed on by `interrupt`
        )
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for data in self._process.stdout:
            if line := data.decode(errors="replace").strip().removeprefix("^C"):  # its echo
                self._last = line
                self._say(f"{self._machine.name}: {line}")

    def interrupt(self) -> None:
        assert self._process.stdin is not None
        with suppress(OSError):  # it has ended
            self._process.stdin.write(CTRL_C)
            self._process.stdin.flush()

    def end(self, seconds: float) -> None:
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        self._process.kill()

    def failure(self) -> str:
        """Wait for the end, and return why the machine is not up; empty if it is."""
        code = self._process.wait()
        self._reader.join()
        name, there = self._machine.name, self._machine.ssh
        if code == SSH_FAILED:
            return (
                f"{name}: ssh cannot connect to {there} without questions ({self._last}); try "
                f"`ssh -o BatchMode=yes {there} true`, and set up its host key and a login by key"
            )
        if code in (NOT_EXECUTABLE, NOT_FOUND):
            return (
                f"{name}: {there} has no command {self._machine.hitab} ({self._last}); install "
                f"HiTAB there, or write its path as `hitab:` under {name}"
            )
        return f"{name}: `hitab up` ended on {there} with exit code {code}" if code else ""
