"""Why a process of a running swarm does not answer: what its supervisor and the system know."""

from __future__ import annotations

import http.client
import socket
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from xmlrpc.client import Fault, ProtocolError, ServerProxy, Transport

import psutil  # type: ignore[import-untyped]

from hitab_client.errors import SwarmError
from hitab_client.run_folder import RunRecord

RPC_SECONDS = 5.0
"""How long to wait for the supervisor."""

FRESH_SECONDS = 0.3
"""How long the supervisor's answer is used before it is asked again."""

ENDED = ("EXITED", "FATAL", "UNKNOWN")
STOPPED = ("STOPPED", "STOPPING")
STARTING = ("STARTING", "BACKOFF")


class _SocketConnection(http.client.HTTPConnection):
    """HTTP over a socket file."""

    def __init__(self, path: str) -> None:
        super().__init__("localhost", timeout=RPC_SECONDS)
        self._path = path

    def connect(self) -> None:
        """Connect."""
        self.sock = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.sock.settimeout(self.timeout)
        self.sock.connect(self._path)


class _SocketTransport(Transport):
    """XML-RPC over a socket file."""

    def __init__(self, path: str) -> None:
        super().__init__()
        self._path = path

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        """Return the connection."""
        return _SocketConnection(self._path)


def process_states(record: RunRecord) -> list[dict[str, Any]]:
    """Return the supervisor's data on each process: name, statename, pid, exitstatus.

    Raises:
        SwarmError: if the supervisor does not answer.
    """
    proxy = ServerProxy("http://localhost", transport=_SocketTransport(record.socket))
    try:
        found: Any = proxy.supervisor.getAllProcessInfo()
        return list(found)
    except (OSError, Fault, ProtocolError, http.client.HTTPException) as error:
        raise SwarmError(
            f'the supervisor of swarm "{record.swarm}" does not answer ({error}); '
            "stop the rest with `hitab down`, then start it again with `hitab up`"
        ) from None


@dataclass(frozen=True)
class Silence:
    """Why an agent or the world does not answer.

    Attributes:
        text: the reason, and the way out.
        lasts: whether waiting is no use.
    """

    text: str
    lasts: bool


class RunProcesses:
    """The processes of a swarm that `hitab up` has started."""

    def __init__(self, record: RunRecord) -> None:
        self._record = record
        self._states: Mapping[str, Mapping[str, Any]] = {}
        self._asked = -FRESH_SECONDS

    def __contains__(self, name: str) -> bool:
        """Whether the swarm has started this agent, or world."""
        return name in self._record.agents or (name == "world" and self._record.world)

    def why_silent(self, name: str) -> Silence | None:
        """Return why an agent or the world does not answer; None: its process looks healthy."""
        process = self._record.process_of(name)
        state = self._state(process)
        if state is None:
            return None
        whose = f"{name}'s process" if process == name else f"{process}, which runs {name},"
        logs = f"see `hitab logs {process}`"
        said = state["statename"]
        if said in ENDED:
            return Silence(f"{whose} has ended{_how(state)}; {logs}", lasts=True)
        if said in STOPPED:
            return Silence(f"{whose} was stopped through its supervisor; {logs}", lasts=True)
        if said in STARTING:
            how = _how(state) if said == "BACKOFF" else ""
            return Silence(f"{whose} is being started again{how}; {logs}", lasts=False)
        pid = state["pid"]
        try:
            suspended = psutil.Process(pid).status() == psutil.STATUS_STOPPED
        except psutil.Error:
            return None
        if suspended:
            way_out = f"`kill -CONT {pid}` lets it continue"
            return Silence(f"{whose} is suspended (process {pid}); {way_out}", lasts=True)
        return None

    def pid(self, name: str) -> int:
        """Return the process id for an agent or the world; 0: it has none."""
        state = self._state(self._record.process_of(name))
        return int(state["pid"]) if state is not None else 0

    def _state(self, process: str) -> Mapping[str, Any] | None:
        if time.monotonic() > self._asked + FRESH_SECONDS:
            try:
                self._states = {state["name"]: state for state in process_states(self._record)}
            except SwarmError:
                self._states = {}
            self._asked = time.monotonic()
        return self._states.get(process)


def _how(state: Mapping[str, Any]) -> str:
    """Return how a process ended, in parentheses."""
    status = state.get("exitstatus", 0)
    return " (killed)" if status < 0 else f" (exit status {status})"
