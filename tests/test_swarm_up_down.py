"""Swarms come up whole or not at all, and go down without leaving anything behind."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from waiting import within

from hitab_client.runs.run_folder import MARK, RunFolder, running_swarms
from hitab_client.runs.run_processes import process_states

LONE = "swarm: one\ndomain: keepaway\nagents: {lone: {}}\n"
SOCCER = """\
swarm: soccer
world: {kind: keepaway, pace: lockstep, paused: true}
domain: keepaway
agents: {keeper_1: {}, keeper_2: {}, keeper_3: {}}
"""
BROKEN = """\
swarm: broken
world: {kind: keepaway, parameters: {taker_speed: -1.0}}
domain: keepaway
agents: {broken_agent: {}}
"""

WRONG_TYPE = """\
swarm: mistyped
domain: keepaway
agents:
  mistyped_agent:
    parameters: {action_timeout: soon}
"""


def described(folder: Path, text: str) -> str:
    path = folder / "swarm.yaml"
    path.write_text(text)
    return str(path)


def test_a_swarm_comes_up_answers_and_goes_down_in_any_folder(hitab, apart, monkeypatch):
    lab = apart / "Robot #2 ; 100% of O'Hara's %(here)s"
    lab.mkdir()
    monkeypatch.setenv("HITAB_HOME", str(lab))
    up = hitab("up", described(lab, SOCCER))
    assert up.returncode == 0, up.stderr
    assert "soccer is up: 3 agents and a world" in up.stdout
    ((folder, record),) = running_swarms()
    names = {state["name"] for state in process_states(record)}
    assert names == {"world", "keeper_1", "keeper_2", "keeper_3"}
    again = hitab("up", described(apart, SOCCER))
    assert again.returncode == 1
    assert 'swarm "soccer" is already up' in again.stderr

    # In another folder it said "is up" while its own processes died and were started again.
    again = hitab("up", described(apart, SOCCER), "--run-dir", str(apart / "other"))
    assert again.returncode == 1
    refused, *ways_out = again.stderr.splitlines()
    assert "keeper_1, keeper_2, keeper_3, world" in refused
    assert all(line.startswith("  ") for line in ways_out)
    assert "`hitab down soccer`" in " ".join(ways_out)
    assert "choose another ROS_DOMAIN_ID" in refused
    assert RunFolder(apart / "other").processes() == []

    told = json.loads(hitab("status", "--json", "-").stdout)
    assert [agent["agent"] for agent in told["agents"]] == ["keeper_1", "keeper_2", "keeper_3"]
    assert (told["world"]["mode"], told["missing"]) == ("paused", [])

    down = hitab("down")
    assert (down.returncode, down.stdout) == (0, "soccer is down\n"), down.stderr
    assert folder.processes() == []
    assert list(running_swarms()) == []
    assert not Path(record.socket).exists()


def test_what_does_not_start_is_told_with_its_log_and_nothing_is_left(hitab, apart):
    up = hitab("up", described(apart, BROKEN))
    assert up.returncode == 1
    assert "world ended while starting; the end of" in up.stderr
    assert "(exit status " in up.stderr
    assert "taker_speed is -1.0; it must not be negative" in up.stderr
    assert "Traceback" not in up.stderr
    assert RunFolder.of_swarm("broken").processes() == []


def test_a_parameter_of_another_type_is_told_with_its_line_in_the_swarm_file(hitab, apart):
    path = described(apart, WRONG_TYPE)
    up = hitab("up", path)
    assert up.returncode == 1
    assert up.stderr.startswith(f"error: {path}:5: mistyped_agent ended while starting; ")
    told = 'the parameter "action_timeout" is the text "soon"; it must be such as 2.0'
    assert told in up.stderr
    assert "Traceback" not in up.stderr


@pytest.fixture
def read_only(tmp_path: Path):
    """Return a folder in which nobody can write, the administrator included."""
    folder = tmp_path / "read_only"
    folder.mkdir()
    if os.geteuid() != 0:
        folder.chmod(0o555)
        yield folder
        return
    mount = ["mount", "-t", "tmpfs", "-o", "ro", "none", str(folder)]
    if subprocess.run(mount, check=False).returncode != 0:
        pytest.skip("the administrator of this container cannot mount")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_read_only_place_for_the_files_of_a_swarm_is_told_with_the_way_out(
    hitab, apart, read_only
):
    for option in ("--run-dir", "--library"):
        up = hitab("up", described(apart, LONE), option, str(read_only / "new"))
        assert up.returncode == 1, option
        told = " ".join(up.stderr.split())
        assert f"{read_only}" in told
        assert "Read-only file system" in told or "Permission denied" in told
        assert "; choose another" in told
        assert "Traceback" not in told
    assert list(running_swarms()) == []


def test_a_swarm_whose_supervisor_died_is_replaced_or_taken_down(hitab, apart):
    for _ in range(2):  # the second one takes the place of what is left of the first
        up = hitab("up", described(apart, LONE))
        assert up.returncode == 0, up.stderr
        ((folder, record),) = running_swarms()
        agents = [p for p in folder.processes() if "hitab_agent.agent_main" in p.cmdline()]
        assert len(agents) == 1
        os.kill(record.supervisor, signal.SIGKILL)
        assert within(10, lambda f=folder, r=record: f.supervisor(r) is None)
        assert folder.processes()
        assert list(running_swarms()) == []
    assert hitab("down", "--swarm", record.identity).stdout == "one is down\n"
    assert folder.processes() == []


def test_ctrl_c_while_it_comes_up_leaves_nothing_behind(apart):
    folder = RunFolder.of_swarm("soccer")
    command = subprocess.Popen(
        [sys.executable, "-m", "hitab_cli.main", "up", described(apart, SOCCER)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, MARK: ""},
    )
    assert within(20, folder.processes)
    command.send_signal(signal.SIGINT)
    _, told = command.communicate(timeout=30)
    assert command.returncode == 130
    assert "Traceback" not in told
    assert folder.processes() == []
    assert list(running_swarms()) == []
