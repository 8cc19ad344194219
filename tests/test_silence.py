"""Whoever does not answer is named with the reason; nobody else is suggested in its place."""

import os
import pty
import select
import signal
import subprocess
import sys

import psutil
import pytest
from waiting import within

from hitab_client import RosLink, SwarmClient, SwarmError, WorldClient
from hitab_client.run_processes import RunProcesses, process_states

ONE = "keeper_1"


@pytest.fixture(scope="module")
def swarm(keepers):
    return keepers


def pid_of(swarm, process: str) -> int:
    return next(s["pid"] for s in process_states(swarm.record) if s["name"] == process)


@pytest.fixture
def suspended(swarm):
    """Return a function that stops a process without ending it."""
    pids = []

    def suspend(process: str) -> int:
        pids.append(pid_of(swarm, process))
        os.kill(pids[-1], signal.SIGSTOP)
        assert within(20, lambda: psutil.Process(pids[-1]).status() == psutil.STATUS_STOPPED)
        return pids[-1]

    yield suspend
    for pid in pids:
        os.kill(pid, signal.SIGCONT)


@pytest.mark.parametrize(
    "call",
    [
        ("demonstrate", ONE, "Stop"),
        ("distribute", "keeper_2", "A", "--to", ONE),
    ],
)
def test_a_suspended_agent_is_named_with_the_way_out(swarm, hitab, suspended, call):
    pid = suspended(ONE)
    done = hitab(*call)
    assert done.returncode == 1
    assert (
        f"error: {ONE}'s process is suspended (process {pid}); `kill -CONT {pid}`" in done.stderr
    )
    assert "keeper_3" not in done.stderr


def test_the_watching_status_notices_who_falls_silent(swarm, suspended):
    terminal, other_end = pty.openpty()
    environment = {**os.environ, "COLUMNS": "200", "LINES": "50"}
    command = [sys.executable, "-m", "hitab_bringup.main", "status", "--watch"]
    watching = subprocess.Popen(
        command, stdin=other_end, stdout=other_end, stderr=other_end, env=environment
    )
    seen = bytearray()

    def shows(text: str) -> bool:
        while select.select([terminal], [], [], 0.0)[0]:
            seen.extend(os.read(terminal, 1 << 16))
        return text.encode() in seen

    try:
        assert within(60, lambda: shows("keeper_3"))
        assert not shows("is suspended")
        pid = suspended("keeper_3")
        assert within(60, lambda: shows(f"keeper_3's process is suspended (process {pid})"))
    finally:
        watching.kill()
        watching.wait()
        os.close(other_end)
        os.close(terminal)


def test_an_agent_that_runs_but_does_not_answer_is_silent_for_as_long_as_it_was_waited_for(
    swarm, monkeypatch
):
    monkeypatch.setattr(os, "getloadavg", lambda: (0.0, 0.0, 0.0))
    with RosLink(swarm.record.domain_id) as link:
        # Nothing is on these topics, as if the agents and the world hung.
        expected, processes = swarm.record.agents, RunProcesses(swarm.record)
        agents = SwarmClient(link, expected, prefix="/elsewhere", processes=processes)
        with pytest.raises(SwarmError) as refused:
            agents.await_agent(ONE, seconds=0.5)
        pid = pid_of(swarm, ONE)
        waited = round(0.5 + agents.more_seconds, 1)
        assert str(refused.value) == (
            f"{ONE} has been silent for {waited:g} s; its process ({pid}) still runs; "
            f"see `hitab logs {ONE}`"
        )
        world = WorldClient(link, prefix="/elsewhere", processes=processes)
        with pytest.raises(SwarmError, match=r"the world has been silent for 0\.5 s"):
            world.wait(0.5)
