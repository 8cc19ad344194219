"""Where a running swarm keeps its files, and how the other verbs find it.

~/.local/state/hitab/            or $XDG_STATE_HOME/hitab, or $HITAB_HOME
keepaway/                      the run folder of swarm "keepaway"
run.json                     there while the swarm is up
supervisord.conf  supervisord.log  logs/keeper_1.log ...
libraries/keeper_1/          kept from run to run
state/keeper_1/              journals of trainings
running/keepaway -> ../keepaway
"""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import psutil  # type: ignore[import-untyped]

from hitab_bringup.errors import SwarmError
from hitab_core.errors import has

MARK = "HITAB_RUN_FOLDER"
"""Environment variable by which the processes of a run folder are recognized."""

SOCKET = "supervisord.sock"
LONGEST_SOCKET = 90
"""Characters; supervisord makes it under a longer name first, and the system allows 107."""


@dataclass(frozen=True)
class RunRecord:
    """What is kept about a swarm while it is up."""

    swarm: str
    description: str
    domain_id: int
    discovery_range: str
    agents: tuple[str, ...]
    world: bool
    supervisor: int
    socket: str


def state_home() -> Path:
    """Return the folder that holds the run folders."""
    if home := os.environ.get("HITAB_HOME"):
        return Path(home)
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "hitab"


class RunFolder:
    """The folder of one swarm."""

    def __init__(self, path: Path) -> None:
        self.path = path.resolve()

    @classmethod
    def of_swarm(cls, name: str, given: Path | None = None) -> RunFolder:
        """Return the folder of a swarm: where the user says, else the default one."""
        return cls(given or state_home() / name)

    @property
    def record_file(self) -> Path:
        """There while the swarm is up."""
        return self.path / "run.json"

    def log(self, process: str) -> Path:
        """Return the log of a process."""
        return self.path / "logs" / f"{process}.log"

    def tail(self, process: str, lines: int = 12) -> list[str]:
        """Return the last lines of a process's log, without what is known to be harmless."""
        try:
            text = self.log(process).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return []
        kept = [line for line in text.splitlines() if "open_and_lock_file failed" not in line]
        return kept[-lines:]

    def socket_path(self) -> Path:
        """Return a path for the supervisor's socket: short, since a socket's must be."""
        here = self.path / SOCKET
        if len(str(here)) < LONGEST_SOCKET:
            return here
        # The folder for temporary files may be as deep.
        folders = (tempfile.gettempdir(), "/tmp")
        short = next((f for f in folders if len(f) + 30 < LONGEST_SOCKET), folders[0])
        return Path(tempfile.mkdtemp(prefix="hitab-", dir=short)) / SOCKET

    def prepare(self) -> None:
        """Make the folders.

        Raises:
            SwarmError: if that cannot be done.
        """
        try:
            for inner in ("logs", "libraries", "state"):
                (self.path / inner).mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise SwarmError(
                f"the run folder {self.path} cannot be made ({error.strerror}); choose another "
                "with --run-dir, or set HITAB_HOME"
            ) from None

    def read(self) -> RunRecord | None:
        """Return the record of the swarm that is, or was, up here."""
        try:
            value = json.loads(self.record_file.read_text(encoding="utf-8"))
            return RunRecord(**{**value, "agents": tuple(value["agents"])})
        except (OSError, ValueError, TypeError, KeyError):
            return None

    def write(self, record: RunRecord, *, register: bool) -> None:
        """Keep the record, and let other verbs find it."""
        partial = self.record_file.with_suffix(".partial")
        partial.write_text(json.dumps(asdict(record), indent=2) + "\n", encoding="utf-8")
        partial.replace(self.record_file)
        if register:
            link = _registered(record.swarm)
            link.parent.mkdir(parents=True, exist_ok=True)
            link.unlink(missing_ok=True)
            link.symlink_to(self.path)

    def forget(self) -> None:
        """Remove the record and the socket: the swarm is down."""
        record = self.read()
        self.record_file.unlink(missing_ok=True)
        if record is None:
            return
        socket = Path(record.socket)
        socket.unlink(missing_ok=True)
        if socket.parent != self.path and socket.parent.name.startswith("hitab-"):
            socket.parent.rmdir()
        link = _registered(record.swarm)
        if link.is_symlink() and link.resolve() == self.path:
            link.unlink()

    def supervisor(self, record: RunRecord) -> psutil.Process | None:
        """Return the supervisor, if it is alive; its number may have been given to another."""
        try:
            process = psutil.Process(record.supervisor)
            if process.status() == psutil.STATUS_ZOMBIE:
                return None
            return process if _mark_of(process) == str(self.path) else None
        except psutil.Error:
            return None

    def processes(self) -> list[psutil.Process]:
        """Return all living processes that were started from this folder."""
        mine = str(self.path)
        return [p for p in psutil.process_iter() if p.pid != os.getpid() and _mark_of(p) == mine]


def _mark_of(process: psutil.Process) -> str | None:
    try:
        if process.status() == psutil.STATUS_ZOMBIE:
            return None
        return process.environ().get(MARK)
    except (psutil.Error, OSError):
        return None


def _registered(swarm: str) -> Path:
    return state_home() / "running" / swarm


def running_swarms() -> Iterator[tuple[RunFolder, RunRecord]]:
    """Go through the swarms that are up, temporary ones excepted."""
    for link in sorted((state_home() / "running").glob("*")):
        folder = RunFolder(link)
        record = folder.read()
        if record is not None and folder.supervisor(record) is not None:
            yield folder, record


def find_running(name: str | None) -> tuple[RunFolder, RunRecord] | None:
    """Return the swarm of this name, or the only one that is up; None if none is.

    Raises:
        SwarmError: if several are up and none is named, or the named one is not.
    """
    up = list(running_swarms())
    if name is not None:
        for folder, record in up:
            if record.swarm == name:
                return folder, record
        names = has(record.swarm for _, record in up)
        raise SwarmError(f'no swarm "{name}" is up {names}; start it with `hitab up`')
    if len(up) > 1:
        raise SwarmError(
            f"several swarms are up {has(r.swarm for _, r in up)}; say which with --swarm NAME"
        )
    return up[0] if up else None
