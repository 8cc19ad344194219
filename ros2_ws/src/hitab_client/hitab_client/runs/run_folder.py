"""Run folders: files of a running swarm, through which other verbs find it.

    ~/.local/state/hitab/               or $XDG_STATE_HOME/hitab, or $HITAB_HOME
      keepaway/                         the run folder of swarm "keepaway"
        run.json                        exists while the swarm is up
        supervisord.conf  supervisord.log  logs/keeper_1.log ...
        libraries/keeper_1/             kept between runs
        state/keeper_1/                 trainings, in a database
      running/keepaway-3f9a2c1e -> ../keepaway
      running.lock                      held while a swarm is being added or removed

A link under ``running`` names each swarm that is up.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from datetime import datetime
from pathlib import Path

import psutil  # type: ignore[import-untyped]

from hitab_client.errors import SwarmError
from hitab_client.runs.users import user_home
from hitab_ros.names import WORLD

MARK = "HITAB_RUN_FOLDER"
"""Environment variable that marks the processes of a run folder."""

CONFIGURATION = "supervisord.conf"
SOCKET = "supervisord.sock"
LONGEST_SOCKET = 90
"""Maximum length of the path; supervisord first uses a longer one, and the system allows 107."""

LIBRARIES = "libraries.json"
"""File in a run folder with the library of each agent, by name."""

WORLD_FILES = "world_files.json"
"""File in a run folder with the Python files of the agents' domains, if any."""


@dataclass(frozen=True)
class RunRecord:
    """The record of a swarm while it is up.

    Attributes:
        identity: identity of this start of the swarm, which all nodes publish in their statuses.
        commanders: the agents that are commanders.
        processes: names of the agents in each process, by the process's name.
        namespace: namespace of all nodes, such as ``/left``; empty if none.
        machine: this machine; empty if the swarm runs on one, unnamed.
        machines: names of the processes that the swarm file gives to each machine; empty likewise.

    The agents, commanders, processes and the world are those of the whole swarm, wherever they
    run.
    """

    swarm: str
    description: str
    domain_id: int
    discovery_range: str
    agents: tuple[str, ...]
    world: bool
    supervisor: int
    socket: str
    identity: str = ""
    commanders: tuple[str, ...] = ()
    processes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    namespace: str = ""
    machine: str = ""
    machines: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

    @property
    def processes_here(self) -> tuple[str, ...]:
        """The processes that the swarm file gives to this machine."""
        return self.machines.get(self.machine, tuple(self.processes))

    @property
    def agents_here(self) -> tuple[str, ...]:
        """The agents and commanders that the swarm file gives to this machine."""
        if not self.machines:
            return self.agents
        return tuple(name for here in self.processes_here for name in self.processes[here])

    @property
    def world_here(self) -> bool:
        """Whether the swarm has a world, and it runs on this machine."""
        return self.world and (not self.machines or WORLD in self.processes_here)


def state_home() -> Path:
    """Return the folder that holds the run folders."""
    if home := os.environ.get("HITAB_HOME"):
        return Path(home)
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else user_home() / ".local" / "state") / "hitab"


def libraries_of(folder: Path) -> dict[str, Path]:
    """Return the library of each agent of the current or last swarm in a run folder."""
    try:
        used = json.loads((folder / LIBRARIES).read_text(encoding="utf-8"))
        return {agent: Path(library) for agent, library in used.items()}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


class RunFolder:
    """The folder of one swarm."""

    def __init__(self, path: Path) -> None:
        self.path = path.resolve()

    @classmethod
    def of_swarm(cls, name: str, given: Path | None = None) -> RunFolder:
        """Return the folder of a swarm: the given one, else the default."""
        return cls(given or state_home() / name)

    @property
    def record_file(self) -> Path:
        """Path of the record, which exists while the swarm is up."""
        return self.path / "run.json"

    @property
    def started(self) -> datetime | None:
        """Start time of the current or last swarm here; None without a record."""
        try:
            return datetime.fromtimestamp(self.record_file.stat().st_mtime)
        except OSError:
            return None

    def log(self, process: str) -> Path:
        """Return the log of a process."""
        return self.path / "logs" / f"{process}.log"

    def tail(self, process: str, lines: int = 12) -> list[str]:
        """Return the last lines of a process's log."""
        try:
            text = self.log(process).read_text(encoding="utf-8", errors="replace")
        except OSError:
            return []
        return text.splitlines()[-lines:]

    def socket_path(self) -> Path:
        """Return a path for the supervisor's socket, which must be short."""
        here = self.path / SOCKET
        if len(str(here)) < LONGEST_SOCKET:
            return here
        # The folder for temporary files may be too deep as well.
        folders = (tempfile.gettempdir(), "/tmp")
        short = next((f for f in folders if len(f) + 30 < LONGEST_SOCKET), folders[0])
        return Path(tempfile.mkdtemp(prefix="hitab-", dir=short)) / SOCKET

    def prepare(self) -> None:
        """Create the folders, and check that they can be written.

        Raises:
            SwarmError: if a folder cannot be written.
        """
        try:
            for inner in ("logs", "libraries", "state"):
                (self.path / inner).mkdir(parents=True, exist_ok=True)
                tempfile.TemporaryFile(dir=self.path / inner).close()
        except OSError as error:
            raise SwarmError(
                f"the run folder {self.path} cannot be made or written "
                f"({error.strerror}); choose another with --run-dir, or set HITAB_HOME"
            ) from None

    def read(self) -> RunRecord | None:
        """Return the record of the current or last swarm here."""
        try:
            value = json.loads(self.record_file.read_text(encoding="utf-8"))
            for key in ("agents", "commanders"):
                value[key] = tuple(value.get(key, ()))
            for key in ("processes", "machines"):
                named = value.get(key, {})
                value[key] = {name: tuple(inside) for name, inside in named.items()}
            return RunRecord(**value)
        except (OSError, ValueError, TypeError, KeyError, AttributeError):
            return None

    def write(self, record: RunRecord, *, register: bool) -> None:
        """Write the record; ``register`` lets other verbs find it."""
        partial = self.record_file.with_suffix(".partial")
        partial.write_text(json.dumps(asdict(record), indent=2) + "\n", encoding="utf-8")
        partial.replace(self.record_file)
        if register:
            name = record.identity or record.swarm
            link = _registry() / (f"{name}-{record.machine}" if record.machine else name)
            link.parent.mkdir(parents=True, exist_ok=True)
            self._unregister()
            link.symlink_to(self.path)

    def _unregister(self) -> None:
        """Remove all entries of this folder, and of folders that no longer exist."""
        for link in _registry().glob("*"):
            if link.is_symlink() and (link.resolve() == self.path or not link.exists()):
                link.unlink(missing_ok=True)

    def forget(self) -> None:
        """Remove the record and the socket: the swarm is down."""
        if not self.record_file.exists():
            return
        record = self.read()
        self.record_file.unlink(missing_ok=True)
        if record is None:
            return
        socket = Path(record.socket)
        socket.unlink(missing_ok=True)
        # A supervisor that was killed while it started leaves a second name of its socket.
        for left in socket.parent.glob(f"{SOCKET}.[0-9]*"):
            left.unlink(missing_ok=True)
        if socket.parent != self.path and socket.parent.name.startswith("hitab-"):
            with contextlib.suppress(OSError):  # other entries are not HiTAB's
                socket.parent.rmdir()
        self._unregister()

    @property
    def configuration(self) -> Path:
        """The supervisor's configuration file."""
        return self.path / CONFIGURATION

    def supervisor(self, record: RunRecord) -> psutil.Process | None:
        """Return the supervisor, if it is alive; its process id may have been reused.

        The new owner of the id may even be another process of this folder.
        """
        try:
            process = psutil.Process(record.supervisor)
            if process.status() == psutil.STATUS_ZOMBIE or _mark_of(process) != str(self.path):
                return None
            return process if str(self.configuration) in process.cmdline() else None
        except psutil.Error:
            return None

    def processes(self) -> list[psutil.Process]:
        """Return all running processes that were started from this folder."""
        mine = str(self.path)
        return [process for process, mark in marked_processes() if mark == mine]


def marked_processes() -> Iterator[tuple[psutil.Process, str]]:
    """Yield all running processes that were started from run folders, each with its folder."""
    for process in psutil.process_iter():
        if process.pid != os.getpid() and (mark := _mark_of(process)):
            yield process, mark


def _mark_of(process: psutil.Process) -> str | None:
    try:
        if process.status() == psutil.STATUS_ZOMBIE:
            return None
        return process.environ().get(MARK)
    except (psutil.Error, OSError):
        return None


def _registry() -> Path:
    return state_home() / "running"


Found = tuple[RunFolder, RunRecord]


@contextlib.contextmanager
def registry_held() -> Iterator[None]:
    """Lock the registry, since two swarms starting at once would choose the same ROS domain."""
    lock = _registry().with_suffix(".lock")
    try:
        lock.parent.mkdir(parents=True, exist_ok=True)
        file = lock.open("w")
    except OSError as error:
        raise SwarmError(
            f"{lock} cannot be written ({error.strerror}); choose another folder with HITAB_HOME"
        ) from None
    with file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def registered_swarms() -> Iterator[Found]:
    """Yield the swarms that are up or have crashed, except temporary ones."""
    for link in sorted(_registry().glob("*")):
        folder = RunFolder(link)
        if (record := folder.read()) is not None:
            yield folder, record


def running_swarms() -> Iterator[Found]:
    """Yield the swarms that are up, except temporary ones."""
    for folder, record in registered_swarms():
        if folder.supervisor(record) is not None:
            yield folder, record


def swarms_here() -> Iterator[Found]:
    """Yield this user's swarms that are up on this machine, whatever the state folder."""
    for mark in {mark for _, mark in marked_processes()}:
        folder = RunFolder(Path(mark))
        record = folder.read()
        if record is not None and folder.supervisor(record) is not None:
            yield folder, record
