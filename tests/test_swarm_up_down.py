"""Swarms come up whole or not at all, stay alive, and go down without leaving anything behind."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import psutil
import pytest
from waiting import within

from hitab_client.run_folder import MARK, RunFolder, running_swarms
from hitab_client.run_processes import process_states

ONE = """\
swarm: {name}
domain: keepaway
agents: {{{agent}: {{}}}}
"""
WITH_WORLD = """\
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


def write(folder: Path, name: str, text: str) -> str:
    path = folder / f"{name}.yaml"
    path.write_text(text)
    return str(path)


def bring_up(hitab, folder: Path, name: str, agent: str) -> str:
    """Bring up a swarm of one agent and return its description."""
    path = write(folder, name, ONE.format(name=name, agent=agent))
    up = hitab("up", path)
    assert up.returncode == 0, up.stderr
    return path


def processes_of(folder: RunFolder) -> list[psutil.Process]:
    return folder.processes()


def test_a_swarm_comes_up_answers_and_goes_down(hitab, apart):
    up = hitab("up", write(apart, "soccer", WITH_WORLD))
    assert up.returncode == 0, up.stderr
    assert "soccer is up: 3 agents and a world" in up.stdout
    ((folder, record),) = running_swarms()
    assert {state["name"]: state["statename"] for state in process_states(record)}.keys() == {
        "world",
        "keeper_1",
        "keeper_2",
        "keeper_3",
    }

    again = hitab("up", str(apart / "soccer.yaml"))
    assert again.returncode == 1
    assert 'swarm "soccer" is already up' in again.stderr

    status = hitab("status", "--json", "-")
    told = json.loads(status.stdout)
    assert [agent["agent"] for agent in told["agents"]] == ["keeper_1", "keeper_2", "keeper_3"]
    assert told["world"]["mode"] == "paused"
    assert told["missing"] == []

    down = hitab("down")
    assert (down.returncode, down.stdout) == (0, "soccer is down\n"), down.stderr
    assert processes_of(folder) == []
    assert list(running_swarms()) == []
    assert not Path(record.socket).exists()


def test_what_does_not_start_is_told_with_its_log_and_nothing_is_left(hitab, apart):
    up = hitab("up", write(apart, "broken", BROKEN))
    assert up.returncode == 1
    assert "world ended while starting; the end of" in up.stderr
    assert "(exit status " in up.stderr
    assert "taker_speed is -1.0; it must not be negative" in up.stderr
    assert "Traceback" not in up.stderr
    assert processes_of(RunFolder.of_swarm("broken")) == []


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
    description = write(apart, "one", ONE.format(name="one", agent="keeper_1"))
    new = read_only / "new"
    for option, folder in (("--run-dir", read_only), ("--run-dir", new), ("--library", new)):
        up = hitab("up", description, option, str(folder))
        assert up.returncode == 1, folder
        told = " ".join(up.stderr.split())
        assert f"{folder}" in told
        assert "Read-only file system" in told or "Permission denied" in told
        assert "; choose another" in told
        assert "Traceback" not in told
    assert list(running_swarms()) == []


def test_a_stale_run_folder_does_not_keep_a_swarm_from_coming_up(hitab, apart):
    path = bring_up(hitab, apart, "one", "lone")
    ((folder, record),) = running_swarms()
    os.kill(record.supervisor, signal.SIGKILL)
    assert within(5, lambda: folder.supervisor(record) is None)
    again = hitab("up", path)
    assert again.returncode == 0, again.stderr
    agents = [p for p in processes_of(folder) if "hitab_agent.agent_main" in p.cmdline()]
    assert len(agents) == 1


def test_ctrl_c_while_it_comes_up_leaves_nothing_behind(apart):
    path = write(apart, "soccer", WITH_WORLD)
    folder = RunFolder.of_swarm("soccer")
    command = subprocess.Popen(
        [sys.executable, "-m", "hitab_bringup.main", "up", path],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, MARK: ""},
    )
    assert within(20, lambda: processes_of(folder))
    command.send_signal(signal.SIGINT)
    _, told = command.communicate(timeout=30)
    assert command.returncode == 130
    assert "Traceback" not in told
    assert processes_of(folder) == []
    assert list(running_swarms()) == []
