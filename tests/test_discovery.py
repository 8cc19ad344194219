"""All processes on this machine find each other, and nobody beyond it is listened to."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import psutil
import pytest

from hitab_bringup.processes.bringing_up import temporary_swarm
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client import domain_ids
from hitab_client.connecting.dds_profile import (
    RANGE,
    VARIABLES,
)
from hitab_client.runs.run_processes import process_states

ROOT = Path(__file__).parents[1]
CHATTER = Path(__file__).with_name("chatter.py")
SECONDS = 150
ONE = "swarm: one\ndomain: keepaway\nagents: {loner: {}}\n"


def environment(domain: int, **changes: str | None) -> dict[str, str]:
    """Return what a shell has after `. scripts/env.sh`, in a domain of its own."""
    before = {k: v for k, v in os.environ.items() if k not in (RANGE, *VARIABLES)}
    script = ["bash", "-c", '. "$0"; env -0', str(ROOT / "scripts" / "env.sh")]
    shown = subprocess.run(script, env=before, capture_output=True, check=True).stdout.decode()
    after = dict(item.split("=", 1) for item in shown.split("\0") if "=" in item)
    after |= {"ROS_DOMAIN_ID": str(domain)}
    for name, value in changes.items():
        after.pop(name, None)
        if value is not None:
            after[name] = value
    return after


PLAIN: dict[str, str | None] = {RANGE: "LOCALHOST", **dict.fromkeys(VARIABLES)}
"""What another ROS program on this machine has set."""


@contextmanager
def talkers(count: int, environment: dict[str, str], processes: int = 1) -> Iterator[list[int]]:
    """Have participants talk meanwhile; yield the processes."""
    with ExitStack() as stack:
        each, started = count // processes, []
        for number in range(processes):
            line = [sys.executable, str(CHATTER), "talk", str(number * each), str(each)]
            started.append(
                stack.enter_context(
                    subprocess.Popen(
                        line, env=environment, stdin=subprocess.PIPE, stdout=subprocess.PIPE
                    )
                )
            )
        try:
            for process in started:
                assert process.stdout is not None
                assert process.stdout.readline() == b"ready\n"
            yield [process.pid for process in started]
        finally:
            for process in started:
                process.kill()


def heard(count: int, environment: dict[str, str]) -> int:
    """Return how many a process hears that starts now."""
    line = [sys.executable, str(CHATTER), "hear", str(count), str(SECONDS)]
    done = subprocess.run(
        line, env=environment, capture_output=True, text=True, check=True, timeout=SECONDS + 60
    )
    return int(done.stdout.split()[-1])


def addresses(pids: list[int]) -> set[str]:
    """Return the addresses that processes have sockets at."""
    sockets = [s for pid in pids for s in psutil.Process(pid).net_connections("inet")]
    return {str(socket.laddr[0]) for socket in sockets if socket.laddr}


def test_a_process_started_late_hears_all_others(request: pytest.FixtureRequest) -> None:
    """With ROS's own LOCALHOST it hears 32 of them, for ever."""
    participants = 100 if request.config.getoption("long") else 40
    with domain_ids.reserved() as domain:
        shell = environment(domain)
        with talkers(participants, shell, processes=participants // 10):
            assert heard(participants, shell) == participants


def test_other_ros_programs_on_this_machine_hear_ours_and_are_heard() -> None:
    """Ours use another discovery range and no shared memory."""
    with domain_ids.reserved() as domain:
        ours, theirs = environment(domain), environment(domain, **PLAIN)
        with talkers(2, ours):
            assert heard(2, theirs) == 2
        with talkers(2, theirs):
            assert heard(2, ours) == 2


def test_a_swarm_listens_to_this_machine_only(home: Path, tmp_path: Path, monkeypatch) -> None:
    for name in (RANGE, *VARIABLES):
        monkeypatch.delenv(name, raising=False)
    with temporary_swarm(parse_swarm(ONE, tmp_path / "one.yaml"), tmp_path / "run") as running:
        pids = [state["pid"] for state in process_states(running.record)]
        assert addresses([running.record.supervisor, *pids, os.getpid()]) == {"127.0.0.1"}
