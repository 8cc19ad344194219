"""Run folders and supervisor configuration: leftovers of a swarm are removed."""

import configparser
import subprocess
from pathlib import Path

import pytest

from hitab_bringup.processes.supervisor_config import supervisor_config, write_commands
from hitab_bringup.processes.swarm_processes import processes
from hitab_bringup.swarm_files.swarm_file import parse_swarm
from hitab_client.errors import SwarmError
from hitab_client.runs.run_folder import RunFolder, RunRecord, state_home
from hitab_client.runs.swarm_choice import find_running


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))


def record(socket: str, swarm: str = "trio") -> RunRecord:
    # Process 1 is alive, but was not started from here.
    return RunRecord(swarm, "trio.yaml", 7, "LOCALHOST", ("a",), False, 1, socket)


def test_a_record_of_a_swarm_that_is_gone_is_not_taken_for_one_that_is_up():
    folder = RunFolder.of_swarm("trio")
    folder.prepare()
    folder.write(record(str(folder.path / "s")), register=True)
    assert folder.read() == record(str(folder.path / "s"))
    assert find_running(None) is None
    with pytest.raises(SwarmError, match=r'no swarm "trio" is up, and no other'):
        find_running("trio")
    folder.forget()
    assert folder.read() is None
    assert list((state_home() / "running").iterdir()) == []


def test_a_deep_run_folder_gets_its_socket_elsewhere(tmp_path):
    folder = RunFolder(tmp_path / ("x" * 80) / "y")
    folder.prepare()
    socket = folder.socket_path()
    assert len(str(socket)) < 90
    socket.touch()
    folder.write(record(str(socket)), register=False)
    folder.forget()
    assert not socket.parent.exists()


def test_what_a_supervisor_left_that_was_killed_while_it_started_is_removed(tmp_path):
    folder = RunFolder(tmp_path / ("x" * 80) / "y")
    folder.prepare()
    socket = folder.socket_path()
    Path(f"{socket}.4711").touch()
    folder.write(record(str(socket)), register=False)
    folder.forget()
    assert not socket.parent.exists()
    folder.write(record(str(folder.socket_path())), register=False)
    other = Path(folder.read().socket).with_name("other")
    other.touch()
    folder.forget()
    assert other.exists(), "it belongs to another program"
    assert folder.read() is None


def test_the_supervisor_is_told_every_process_whatever_its_path_looks_like(tmp_path):
    folder = tmp_path / "100% mine # ; 'and' \"yours\""
    folder.mkdir()
    swarm = parse_swarm("domain: keepaway\nagents: {a: {}, b: {behavior: Stop}}\n", Path("x.yaml"))
    started = processes(swarm, folder)
    write_commands(started, folder)
    parser = configparser.RawConfigParser()
    parser.read_string(supervisor_config(started))
    for process in started:
        shell, file = parser[f"program:{process.name}"]["command"].split()
        words = (folder / file).read_text().removeprefix("exec ")
        show = [shell, "-c", f"set -- {words}\nprintf '%s\\n' \"$@\""]
        output = subprocess.run(show, capture_output=True, text=True, check=True).stdout
        assert output.splitlines() == process.command
    assert parser["unix_http_server"]["chmod"] == "0700"
    assert "inet_http_server" not in parser
