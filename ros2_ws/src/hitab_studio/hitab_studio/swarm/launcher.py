"""Starts and stops swarms with the ``hitab`` command."""

from __future__ import annotations

import asyncio
import os
import sys
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path

from hitab_client import SwarmError
from hitab_client.runs.shipped import shipped_folders, shipped_names
from hitab_client.terminal.cli_remedies import called
from hitab_core import has

NONE: Mapping[str, str] = {}
LINES_MAX = 40
"""Lines of the command's output that are kept."""


@dataclass
class Launch:
    """One run of the command, possibly finished.

    Attributes:
        verb: up or down.
        began: time of the start on the monotonic clock, s.
        lines: output of the command.
        status: exit status of the command; None while the command runs.
    """

    verb: str
    swarm: str
    began: float
    lines: list[str] = field(default_factory=list)
    status: int | None = None

    @property
    def seconds(self) -> int:
        """Time since the launch, s."""
        return round(time.monotonic() - self.began)


class Launcher:
    """Runs the command for all pages, one swarm at a time.

    Args:
        startable: descriptions of the swarms that may be started, by name.
        changed: called when pages should be redrawn.

    Attributes:
        launch: the running command, or the failed one until dismissed; None otherwise.
    """

    def __init__(
        self, startable: Mapping[str, str] = NONE, changed: Callable[[], None] = lambda: None
    ) -> None:
        self.startable = startable
        self.launch: Launch | None = None
        self._changed = changed
        self._task: asyncio.Task[None] | None = None

    @property
    def is_busy(self) -> bool:
        """Whether the command is running."""
        return self.launch is not None and self.launch.status is None

    def run(self, verb: str, swarm: str) -> None:
        """Run ``hitab up`` or ``hitab down``; pages show the output.

        Raises:
            SwarmError: if the command is already running.
        """
        if self.launch is not None and self.launch.status is None:
            doing = "started" if self.launch.verb == "up" else "stopped"
            raise SwarmError(f"{self.launch.swarm} is being {doing}: wait until that is done.")
        self.launch = Launch(verb, swarm, time.monotonic())
        self._changed()
        self._task = asyncio.create_task(self._follow(self.launch))

    def dismiss(self) -> None:
        """Dismiss a failed command."""
        if not self.is_busy:
            self.launch = None
            self._changed()

    async def _follow(self, launch: Launch) -> None:
        """Read the command's output until the command ends. The command outlives the studio."""
        try:
            process = await asyncio.create_subprocess_exec(
                *command(),
                launch.verb,
                launch.swarm,
                stdin=asyncio.subprocess.DEVNULL,
                stdout=asyncio.subprocess.PIPE,
                stderr=asyncio.subprocess.STDOUT,
                env={**os.environ, "NO_COLOR": "1"},
                start_new_session=True,
            )
            assert process.stdout is not None
            while line := await process.stdout.readline():
                launch.lines.append(line.decode(errors="replace").rstrip())
                del launch.lines[:-LINES_MAX]
                self._changed()
            launch.status = await process.wait()
        except (OSError, ValueError, SwarmError) as error:
            launch.lines.append(str(error))
            launch.status = -1
        if launch.status == 0:
            self.launch = None
        self._changed()


def command() -> list[str]:
    """Return the command line of ``hitab`` in the environment of this process.

    Raises:
        SwarmError: if ``hitab`` is not installed.
    """
    for point in entry_points(group="console_scripts", name="hitab"):
        return [sys.executable, "-m", point.module]
    raise SwarmError("The command hitab is not installed: install HiTAB again.")


def startable_swarms(only: str | None = None) -> dict[str, str]:
    """Return the shipped swarms and their descriptions, or only the named one if shipped."""
    files = [path for place in shipped_folders("swarms") for path in place.glob("*.yaml")]
    found = {path.stem: _about(path) for path in sorted(files, key=lambda path: path.stem)}
    return {name: about for name, about in found.items() if only in (None, name)}


@cache
def unknown(name: str) -> str:
    """Return the error for a swarm that is not shipped, with the way out; "" if shipped."""
    shipped = sorted(shipped_names("swarms"))
    if name in shipped:
        return ""
    return (
        f'No swarm "{name}" is shipped {has(shipped, name)}. Start one of your own with '
        f"`{called()} up` and its file."
    )


def _about(path: Path) -> str:
    """Return the first paragraph of the comment at the top of a file."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("# "):
            break
        lines.append(line[2:].strip())
    return " ".join(lines)
