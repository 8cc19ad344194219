"""Processes of a running swarm: their states, and why one does not answer."""

from __future__ import annotations

import contextlib
import http.client
import socket
import time
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any
from xml.parsers.expat import ExpatError
from xmlrpc.client import Fault, ProtocolError, ServerProxy, Transport

import psutil  # type: ignore[import-untyped]

from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import RunRecord
from hitab_core import Fix, some
from hitab_ros.names import WORLD
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART
from hitab_ros.timing import DISCOVERY_S, POLL_S, START_S

GROUP = "swarm"
"""Name of the supervisor's group of all processes."""

ENDED_STATES = ("EXITED", "FATAL", "UNKNOWN")
STOPPED_STATES = ("STOPPED", "STOPPING")
STARTING = ("STARTING", "BACKOFF")


class _SocketTransport(Transport):
    """XML-RPC over a socket file."""

    def __init__(self, path: str, seconds: float) -> None:
        super().__init__()
        self._path, self._seconds = path, seconds

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return the connection."""
        connection = http.client.HTTPConnection("localhost")
        connection.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        connection.sock.settimeout(self._seconds)
        connection.sock.connect(self._path)
        return connection


def process_states(record: RunRecord, seconds: float = START_S) -> list[dict[str, Any]]:
    """Return the supervisor's data on each process: name, statename, pid, exitstatus.

    Args:
        record: record of the run.
        seconds: timeout for the supervisor's answer.

    Raises:
        SwarmError: if the supervisor does not answer.
    """
    with _supervisor(record, seconds) as supervisor:
        return list(supervisor.getAllProcessInfo())


def start_process(record: RunRecord, process: str) -> None:
    """Have the supervisor start a process, also one that was added to its configuration.

    Raises:
        SwarmError: if the supervisor does not answer, or does not start it.
    """
    with _supervisor(record, DISCOVERY_S) as supervisor:
        for state in supervisor.getAllProcessInfo():
            if state["name"] == process:
                supervisor.startProcess(f"{state['group']}:{process}", False)
                return
        supervisor.reloadConfig()
        supervisor.addProcessGroup(process)


@contextlib.contextmanager
def _supervisor(record: RunRecord, seconds: float) -> Iterator[Any]:
    """Yield the supervisor's functions; raise `SwarmError` if it does not answer."""
    proxy = ServerProxy("http://localhost", transport=_SocketTransport(record.socket, seconds))
    try:
        yield proxy.supervisor
    except (OSError, Fault, ProtocolError, http.client.HTTPException, ExpatError) as error:
        raise SwarmError(
            f'the supervisor of swarm "{record.swarm}" does not answer ({error})',
            Fix.DOWN(swarm=record.swarm),
            Fix.UP(swarm=record.swarm),
        ) from None


def answers(record: RunRecord) -> bool:
    """Whether the supervisor answers; it does not while starting."""
    try:
        process_states(record, DISCOVERY_S)
    except SwarmError:
        return False
    return True


@dataclass(frozen=True)
class Silence:
    """Reason why a process does not answer.

    Attributes:
        process: name of the process.
        what: reason and way out.
        lasts: whether waiting is useless.
        state: state of the process, in one word.
    """

    process: str
    what: str
    lasts: bool
    state: str = "silent"

    def of(self, *names: str) -> str:
        """Return a sentence that names agents, or the world, in the process."""
        if names == (self.process,):
            return f"{self.process}'s process {self.what}"
        return f"{self.process}, which runs {some(names)}, {self.what}"


class RunProcesses:
    """The processes of a swarm that `hitab up` has started.

    Args:
        record: record of the run; None if no process is known.
    """

    def __init__(self, record: RunRecord | None = None) -> None:
        self._record = record
        self._members = record.processes if record is not None else {}
        self._process_of = {
            name: process for process, names in self._members.items() for name in names
        }
        self._states: Mapping[str, Mapping[str, Any]] = {}
        self._silences: dict[str, Silence | None] = {}
        self._asked = -POLL_S

    @property
    def are_known(self) -> bool:
        """Whether anything is known of the swarm's processes."""
        return self._record is not None

    def __contains__(self, name: str) -> bool:
        """Whether the swarm has started this agent or world."""
        has_world = self._record is not None and self._record.world
        return name in self._process_of or (name == WORLD and has_world)

    def process_of(self, name: str) -> str:
        """Return the name of the process that runs an agent, or the world."""
        return self._process_of.get(name, name)

    def reason(self, name: str) -> SwarmError | None:
        """Return an error for a silent agent or world; None if its process shows no reason."""
        why = self.why_silent(name)
        return None if why is None else SwarmError(why.of(name), Fix.LOGS(node=why.process))

    def why_silent(self, name: str) -> Silence | None:
        """Return why an agent or the world does not answer; None if its process looks healthy."""
        self._ask()
        process = self.process_of(name)
        if process not in self._silences:
            self._silences[process] = self._silence(process)
        return self._silences[process]

    def is_lost(self, name: str) -> bool:
        """Whether waiting for an agent or the world is useless."""
        why = self.why_silent(name)
        return why is not None and why.lasts

    def lost(self) -> Iterator[str]:
        """Yield the agents for which waiting is useless."""
        for process, members in self._members.items():
            if self.is_lost(process):
                yield from members

    @property
    def have_leases(self) -> bool:
        """Whether the swarm is on several machines, where all agents are in hosts with leases."""
        return self._record is not None and bool(self._record.machines)

    def _is_host(self, members: Sequence[str]) -> bool:
        return len(members) > (not self.have_leases)

    def is_hosted(self, name: str) -> bool:
        """Whether an agent or commander runs in a host."""
        return self._is_host(self._members.get(self.process_of(name), ()))

    def hosts_within(self, agents: Set[str]) -> list[Sequence[str]]:
        """Return the agents of each host all of whose agents are among these."""
        hosts = filter(self._is_host, self._members.values())
        return [names for names in hosts if agents >= {*names}]

    def pid(self, name: str) -> int:
        """Return the process id of an agent or the world; 0 if unknown."""
        self._ask()
        state = self._states.get(self.process_of(name))
        return int(state["pid"]) if state is not None else 0

    def _silence(self, process: str) -> Silence | None:
        state = self._states.get(process)
        if state is None:
            return None
        said = state["statename"]
        starts = is_starting(state)
        if said in ENDED_STATES and not starts:
            return Silence(process, f"has ended{_how(state)}", lasts=True, state="ended")
        if said in STOPPED_STATES:
            what = "was stopped through its supervisor"
            return Silence(process, what, lasts=True, state="stopped")
        if starts:
            how = "" if said == "STARTING" else _how(state)
            what = f"is being started again{how}"
            return Silence(process, what, lasts=False, state="restarting")
        pid = state["pid"]
        if is_suspended(pid):
            what = f"is suspended (process {pid}); `kill -CONT {pid}` lets it continue"
            return Silence(process, what, lasts=True, state="suspended")
        return None

    def _ask(self) -> None:
        """Ask the supervisor again if the last answer is too old."""
        if self._record is not None and time.monotonic() > self._asked + POLL_S:
            try:
                self._states = {
                    state["name"]: state for state in process_states(self._record, DISCOVERY_S)
                }
            except SwarmError:
                self._states = {}
            self._silences = {}
            self._asked = time.monotonic()


def is_starting(state: Mapping[str, Any]) -> bool:
    """Return whether the supervisor starts a process, or will start it again; see its data."""
    said = state["statename"]
    return said in STARTING or (said == "EXITED" and state.get("exitstatus", 0) != DO_NOT_RESTART)


def is_suspended(pid: int) -> bool:
    """Return whether a process exists, but is stopped by a signal."""
    try:
        return bool(psutil.Process(pid).status() == psutil.STATUS_STOPPED)
    except psutil.Error:
        return False


def sentences(why: Mapping[str, Silence | None]) -> list[str]:
    """Return a sentence for each process that does not answer, and one for all unexplained.

    Args:
        why: reasons by the names of agents and of the world.
    """
    alike: dict[Silence | None, list[str]] = {}
    for name, silence in why.items():
        alike.setdefault(silence, []).append(name)
    texts = [silence.of(*names) for silence, names in alike.items() if silence is not None]
    if unexplained := alike.get(None):
        texts.append(f"{some(unexplained)} {'does' if len(unexplained) == 1 else 'do'} not answer")
    return texts


def _how(state: Mapping[str, Any]) -> str:
    """Return how a process ended, in parentheses."""
    status = state.get("exitstatus", 0)
    return " (killed)" if status < 0 else f" (exit status {status})"
