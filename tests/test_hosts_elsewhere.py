"""Hosts that the local supervisor does not run count if heard, and yield to newer leases."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import psutil
from test_swarm_identity import described, up
from waiting import within

from hitab_bringup.processes.supervision import environment
from hitab_client.runs.run_folder import RunFolder, running_swarms
from hitab_client.runs.run_processes import process_states
from hitab_ros.nodes.exit_codes import DO_NOT_RESTART

SWARM = """\
swarm: parted
domain: keepaway
world: {kind: keepaway, pace: realtime}
agents:
  keeper_1: {}
  keeper_2: {host: both}
  keeper_3: {host: both}
kinds:
  Pair: {orders: {Halt: Stop}}
commanders:
  captain: {kind: Pair, commands: [keeper_2, keeper_3], host: both}
"""
MEMBERS = ("keeper_2", "keeper_3", "captain")


@contextmanager
def host(
    roster: Path, swarm: str, folder: RunFolder, *more: str
) -> Iterator[subprocess.Popen[str]]:
    """Start a host by hand; its output is read when it has ended."""
    given = [f"roster:={roster}", f"swarm:={swarm}", *more]
    arguments = [part for one in given for part in ("-p", one)]
    process = subprocess.Popen(
        [sys.executable, "-m", "hitab_agent.host_main", "--ros-args", *arguments],
        env={**os.environ, **environment(folder, int(os.environ["ROS_DOMAIN_ID"]))},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        yield process
    finally:
        process.send_signal(signal.SIGCONT)
        process.terminate()
        process.communicate(timeout=60)


def test_agents_of_a_host_that_was_started_elsewhere_are_there_like_any_other(hitab, apart):
    up(hitab, described(apart, SWARM))
    ((folder, record),) = running_swarms()
    ctl = [sys.executable, "-m", "supervisor.supervisorctl", "-s", f"unix://{record.socket}"]
    subprocess.run([*ctl, "stop", "swarm:both"], check=True, stdout=subprocess.DEVNULL)
    stopped = "both, which runs keeper_2, was stopped through its supervisor"
    assert stopped in hitab("perform", "keeper_2", "Stop").stderr
    told = json.loads(hitab("status", "--json", "-").stdout)
    assert told["silent"].keys() == {*MEMBERS}
    roster = folder.path / "rosters" / "both.json"
    with host(roster, record.identity, folder) as elsewhere:
        assert within(60, lambda: hitab("perform", "keeper_2", "Stop").returncode == 0)
        for verb in (
            ("train", "keeper_3", "Hold", "-f", "DistanceTo(ball)"),
            ("demonstrate", "keeper_3", "Stop"),
            ("save", "keeper_3"),
            ("order", "captain", "Halt"),
            ("tree", "captain"),
        ):
            done = hitab(*verb)
            assert done.returncode == 0, done.stderr
            assert "stopped through its supervisor" not in done.stderr
        assert "captain: orders Halt: 2 of 2 perform it" in done.stdout, done.stdout
        told = json.loads(hitab("status", "--json", "-").stdout)
        assert (told["silent"], told["missing"]) == ({}, [])
        states = {state["name"]: state["statename"] for state in process_states(record)}
        assert states["both"] == "STOPPED"

        psutil.Process(elsewhere.pid).suspend()
        assert stopped in hitab("perform", "keeper_2", "Stop").stderr


def test_a_host_yields_to_a_newer_lease_and_is_not_started_again(apart):
    folder = RunFolder(apart / "run")
    folder.prepare()
    rosters = {}
    for machine in ("lab_1", "lab_3"):
        state = {"domain": "keepaway", "state_dir": str(apart / machine)}
        entries = [{"name": name, "parameters": state} for name in MEMBERS[:2]]
        rosters[machine] = apart / machine / "host_2.json"
        rosters[machine].parent.mkdir()
        rosters[machine].write_text(json.dumps(entries))

    def start(machine: str, lease: int):
        lease_of_it = (f"machine:={machine}", f"lease:={lease}")
        return host(rosters[machine], "labs-0000000a", folder, *lease_of_it)

    def is_up(machine: str) -> bool:
        return (apart / machine / "restart" / f"host_of_keeper_2_on_{machine}.json").exists()

    sentence = "error: host_2 runs on lab_3 now (lease 2); this one yields\n"
    with start("lab_1", 1) as old:
        assert within(60, lambda: is_up("lab_1"))
        with start("lab_3", 2) as new:
            assert old.wait(60) == DO_NOT_RESTART
            assert sentence in old.stdout.read()
            with start("lab_1", 1) as returning:
                assert returning.wait(60) == DO_NOT_RESTART
                assert sentence in returning.stdout.read()
            assert new.poll() is None
