"""Run folders, supervisor configuration, shared memory: what a swarm leaves behind is cleaned."""

import configparser
import fcntl
import os
from pathlib import Path

import pytest

from hitab_bringup.shared_memory import left_behind, remove_stale
from hitab_bringup.supervisor_config import supervisor_config
from hitab_bringup.swarm_file import parse_swarm
from hitab_bringup.swarm_processes import processes
from hitab_client.errors import SwarmError
from hitab_client.run_folder import RunFolder, RunRecord, state_home
from hitab_client.swarm_choice import find_running


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))


def record(socket: str, swarm: str = "trio") -> RunRecord:
    # Process 1 is alive, but it is nobody that was started from here.
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


def test_a_truncated_record_is_no_record(tmp_path):
    folder = RunFolder(tmp_path / "run")
    folder.prepare()
    folder.record_file.write_text('{"swarm": "tr')
    assert folder.read() is None


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
    assert other.exists(), "it is somebody else's"
    assert folder.read() is None


def test_the_supervisor_is_told_every_process_whatever_its_path_looks_like(tmp_path):
    folder = tmp_path / "100% mine"
    swarm = parse_swarm("domain: keepaway\nagents: {a: {}, b: {behavior: Stop}}\n", Path("x.yaml"))
    started = processes(swarm, folder)
    text = supervisor_config(started, folder, folder / "logs", folder / "sock")
    parser = configparser.RawConfigParser()
    parser.read_string(text)
    assert {"program:a", "program:b"} <= set(parser.sections())
    assert "100%% mine" in parser["program:a"]["command"]
    assert parser["unix_http_server"]["chmod"] == "0700"
    assert "inet_http_server" not in parser


def test_shared_memory_is_removed_when_nobody_holds_it(tmp_path):
    for name in (
        "fastrtps_dead",
        "fastrtps_dead_el",
        "fastrtps_live",
        "fastrtps_live_el",
        "sem.fastrtps_dead_mutex",
        "sem.fastrtps_live_mutex",
        "other",
    ):
        (tmp_path / name).touch()
    with (tmp_path / "fastrtps_live_el").open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert left_behind(tmp_path) == (3, 0)
        assert remove_stale(tmp_path) == 3
        assert left_behind(tmp_path) == (0, 0)
    assert sorted(os.listdir(tmp_path)) == [
        "fastrtps_live",
        "fastrtps_live_el",
        "other",
        "sem.fastrtps_live_mutex",
    ]


def test_shared_memory_that_is_open_somewhere_is_left_alone(tmp_path):
    path = tmp_path / "fastrtps_port1"
    with path.open("w"):
        assert remove_stale(tmp_path) == 0
    assert remove_stale(tmp_path) == 1
