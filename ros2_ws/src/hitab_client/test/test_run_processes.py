"""The supervisor's process states become reasons and ways out."""

import os
import socketserver
import threading
from xmlrpc.server import SimpleXMLRPCDispatcher, SimpleXMLRPCRequestHandler

import pytest

from hitab_client import run_processes
from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import RunRecord
from hitab_client.runs.run_processes import RunProcesses, process_states, sentences


class Handler(SimpleXMLRPCRequestHandler):
    rpc_paths = ("/RPC2",)
    disable_nagle_algorithm = False  # a socket file has none

    def log_message(self, *_):
        """Keep quiet."""


class Server(socketserver.UnixStreamServer, SimpleXMLRPCDispatcher):
    logRequests = False

    def __init__(self, path: str) -> None:
        SimpleXMLRPCDispatcher.__init__(self)
        socketserver.UnixStreamServer.__init__(self, path, Handler)


def state(name: str, statename: str, pid: int = 0, exitstatus: int = 0) -> dict:
    return {"name": name, "statename": statename, "pid": pid, "exitstatus": exitstatus}


STATES = [
    state("world", "RUNNING", os.getpid()),
    state("a", "EXITED", exitstatus=3),
    state("b", "FATAL", exitstatus=-1),
    state("c", "BACKOFF", exitstatus=1),
    state("d", "STARTING", 4),
    state("e", "STOPPED"),
    state("host_1", "EXITED", exitstatus=1),
]


def record(socket: str) -> RunRecord:
    agents = ("a", "b", "c", "d", "e", "f", "g")
    processes = {"world": (), **{name: (name,) for name in "abcde"}, "host_1": ("f", "g")}
    return RunRecord(
        "team", "t.yaml", 7, "LOCALHOST", agents, True, 1, socket, "team-1", (), processes
    )


@pytest.fixture
def team(tmp_path):
    """Return the record of a swarm whose supervisor reports `STATES`."""
    path = str(tmp_path / "s")
    with Server(path) as server:
        server.register_function(lambda: STATES, "supervisor.getAllProcessInfo")
        thread = threading.Thread(target=server.serve_forever, daemon=True)
        thread.start()
        yield record(path)
        server.shutdown()
        thread.join()


@pytest.mark.parametrize(
    ("name", "text", "lasts"),
    [
        ("a", "a's process has ended (exit status 3)", True),
        ("b", "b's process has ended (killed)", True),
        ("c", "c's process is being started again (exit status 1)", False),
        ("d", "d's process is being started again", False),
        ("e", "e's process was stopped through its supervisor", True),
        (
            "f",
            "host_1, which runs f, is being started again (exit status 1)",
            False,
        ),
    ],
)
def test_a_process_that_does_not_run_is_the_reason_for_silence(team, name, text, lasts):
    why = RunProcesses(team).why_silent(name)
    assert (why.of(name), why.lasts) == (text, lasts)


def test_a_host_is_named_once_for_all_its_agents(team):
    processes = RunProcesses(team)
    why = {name: processes.why_silent(name) for name in ("world", "f", "a", "g")}
    assert sentences(why) == [
        "host_1, which runs f, g, is being started again (exit status 1)",
        "a's process has ended (exit status 3)",
        "world does not answer",
    ]
    assert [processes.is_lost(name) for name in why] == [False, False, True, False]


def test_a_supervisor_that_does_not_answer_is_no_reason_either(tmp_path):
    ended = record(str(tmp_path / "none"))
    assert RunProcesses(ended).why_silent("a") is None
    assert RunProcesses(ended).pid("a") == 0
    with pytest.raises(SwarmError, match='supervisor of swarm "team" does not answer'):
        process_states(ended)


def test_the_supervisor_is_not_asked_for_each_agent(team, monkeypatch):
    monkeypatch.setattr(run_processes, "POLL_S", 1000.0)
    asked = []
    monkeypatch.setattr(
        run_processes,
        "process_states",
        lambda run, seconds: asked.append(run) or STATES,
    )
    processes = RunProcesses(team)
    for name in team.agents:
        processes.why_silent(name)
    assert len(asked) == 1
