"""Hosts in network namespaces, joined by `lossy_switch`; needs root or user namespaces."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Self

SWITCH = Path(__file__).with_name("lossy_switch.py")


def why_not() -> str:
    """Return why this machine cannot have such a network; empty if it can."""
    for tool in ("unshare", "nsenter", "ip"):
        if shutil.which(tool) is None:
            return f"there is no `{tool}`; install util-linux and iproute2"
    cable = "ip link add name probe0 type veth peer name probe1"
    probe = [*_unshare(), *cable.split()]
    done = subprocess.run(probe, capture_output=True, text=True, check=False)
    if done.returncode:
        return (
            "network namespaces with veth cannot be made here; be root, or allow unprivileged "
            f"user namespaces ({done.stderr.strip()})"
        )
    return ""


def shifted_clock(folder: Path) -> Path:
    """Return a library that shifts the wall clock of a process into which it is preloaded."""
    library = folder / "shifted_clock.so"
    source = Path(__file__).with_name("shifted_clock.c")
    subprocess.run(["cc", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True)
    return library


def _unshare() -> list[str]:
    return ["unshare", "-n"] if os.geteuid() == 0 else ["unshare", "-Urn"]


class LossyNetwork:
    """Hosts 1 to n; used with ``with``."""

    def __init__(self, hosts: int, delay_s: float, loss: float) -> None:
        line = [*_unshare(), sys.executable, str(SWITCH), str(hosts), str(delay_s), str(loss)]
        self._switch = subprocess.Popen(
            line, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        self._processes: list[subprocess.Popen[bytes]] = []
        self._holders: list[int] = json.loads(self._answer() or "[]")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        for process in self._processes:
            process.kill()
        for process in self._processes:
            process.wait()
        self._tell("stop")
        self._switch.wait(10.0)

    def enter(self, host: int) -> list[str]:
        """Return the beginning of a command line that runs on a host."""
        line = ["nsenter", "-t", str(self._holders[host - 1]), "-n"]
        return line if os.geteuid() == 0 else [*line, "-U", "--preserve-credentials"]

    def run(
        self, host: int, line: list[str], log: Path, **environment: str
    ) -> subprocess.Popen[bytes]:
        """Start a process on a host; it is killed at the end."""
        with log.open("wb") as output:
            process = subprocess.Popen(
                [*self.enter(host), *line],
                env={**os.environ, **environment},
                stdout=output,
                stderr=subprocess.STDOUT,
            )
        self._processes.append(process)
        return process

    def cut_off(self, host: int) -> None:
        """Let nothing pass to and from a host."""
        self._tell(f"cut {host}")
        self._answer()

    def drop_multicast(self) -> None:
        """Let only unicast and broadcast pass, as many wireless networks do."""
        self._tell("unicast")
        self._answer()

    def heal(self) -> dict[str, int]:
        """Join all again; return how many frames have passed and been lost so far."""
        self._tell("heal")
        counts: dict[str, int] = json.loads(self._answer())
        return counts

    def _tell(self, order: str) -> None:
        assert self._switch.stdin is not None
        self._switch.stdin.write(f"{order}\n")
        self._switch.stdin.flush()

    def _answer(self) -> str:
        assert self._switch.stdout is not None
        return self._switch.stdout.readline()
