"""`hitab doctor` names each problem with its remedy, and reports errors by its exit status."""

import json
import os
import signal
import subprocess
import sys
import time

import psutil
import pytest
from hitab_msgs.msg import AgentStatus

from hitab_bringup.doctor import ros, runs
from hitab_cli.main import make_app
from hitab_client import RosLink, RunFolder, RunRecord, domain_ids, ros_environment
from hitab_client.connecting.dds_profile import LOOPBACK, RANGE, VARIABLES
from hitab_client.runs.run_folder import MARK
from hitab_ros import qos


@pytest.fixture(autouse=True)
def alone(tmp_path, monkeypatch):
    monkeypatch.setenv("HITAB_HOME", str(tmp_path / "home"))
    with domain_ids.reserved() as number:
        monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
        yield number


def one(findings):
    (finding,) = findings
    return finding


def doctor(*arguments: str) -> int:
    with pytest.raises(SystemExit) as ended:
        make_app()(["doctor", *arguments])
    return ended.value.code


def test_an_error_gives_exit_status_1_and_its_way_out_is_printed(monkeypatch, capfd):
    monkeypatch.setenv("ROS_DOMAIN_ID", "abc")
    assert doctor() == 1
    output = capfd.readouterr().out
    assert "error   ROS domain     ROS_DOMAIN_ID=abc is not a number from 0 to 232" in output
    assert "unset ROS_DOMAIN_ID, or choose a number up to 101" in output


@pytest.mark.parametrize(
    ("variables", "level", "text"),
    [
        ({}, "ok", "of processes on this computer only"),
        ({RANGE: "OFF"}, "error", "no node finds another"),
        ({VARIABLES[0]: str(LOOPBACK), RANGE: "SYSTEM_DEFAULT"}, "ok", "this computer only"),
        ({VARIABLES[0]: "/none/own.xml"}, "error", "there is no DDS profile /none/own.xml"),
    ],
)
def test_discovery_is_explained(variables, level, text, monkeypatch):
    for name in (*VARIABLES, RANGE, "RMW_IMPLEMENTATION", "ROS_LOCALHOST_ONLY"):
        monkeypatch.delenv(name, raising=False)
    for name, value in variables.items():
        monkeypatch.setenv(name, value)
    finding = one(f for f in ros.middleware() if f.about == "discovery")
    assert finding.level == level
    assert text in finding.text


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("RMW_IMPLEMENTATION", "rmw_none_cpp", "RMW_IMPLEMENTATION=rmw_none_cpp is not installed"),
        ("ROS_SECURITY_ENABLE", "true", "but ROS from wheels has no DDS security"),
        ("ROS_DISCOVERY_SERVER", "127.0.0.1:9;", "there is no server (Connection refused)"),
        ("HITAB_INTERFACE", "eth77", "this computer has no such interface"),
        ("PYTHONPATH", "{foreign}", "rclpy is loaded from {foreign}/rclpy/__init__.py instead of"),
    ],
)
def test_with_variables_that_ros_cannot_start_with_doctor_goes_on_and_others_refuse(
    name, value, text, monkeypatch, tmp_path
):
    foreign = tmp_path / "humble"
    (foreign / "rclpy").mkdir(parents=True)
    (foreign / "rclpy/__init__.py").write_text("raise ImportError('of another Python')")
    value, text = value.format(foreign=foreign), text.format(foreign=foreign)
    if name in ("ROS_SECURITY_ENABLE", "PYTHONPATH") and not ros_environment.is_from_wheels():
        pytest.skip("with an installed ROS")
    monkeypatch.delenv(RANGE, raising=False)
    for variable in VARIABLES:
        monkeypatch.delenv(variable, raising=False)
    monkeypatch.setenv(name, value)

    def hitab(*arguments: str) -> tuple[str, str]:
        command = [sys.executable, "-m", "hitab_cli.main", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 1
        return done.stdout, done.stderr

    found = json.loads(hitab("doctor", "--json", "-")[0])
    (error,) = [finding for finding in found if finding["level"] == "error"]
    assert text in error["text"]
    assert name in error["way_out"]
    assert found[-1]["about"] == "limits"
    (line,) = hitab("status")[1].splitlines()
    assert line == f"error: {error['text']}; {error['way_out']}"


@pytest.mark.skipif(
    subprocess.run(["unshare", "-rn", "true"], check=False).returncode != 0,
    reason="no network of its own can be made here",
)
def test_a_machine_that_does_not_reach_itself_is_told_how_it_does():
    command = ["unshare", "-rn", sys.executable, "-m", "hitab_cli.main", "status"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "cannot reach itself at 127.0.0.1: Network is unreachable" in done.stderr
    assert "sudo ip link set lo up" in done.stderr


def test_a_suspended_process_of_a_swarm_is_warned_of_with_the_remedy(monkeypatch):
    folder = RunFolder.of_swarm("red")
    folder.prepare()
    record = RunRecord("red", "r.yaml", 7, "LOCALHOST", ("a",), True, 1, "s", "red-1")
    folder.write(record, register=True)
    monkeypatch.setattr(RunFolder, "supervisor", lambda self, record: 1)
    with subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE) as held:
        state = {"name": "a", "statename": "RUNNING", "pid": held.pid}
        monkeypatch.setattr(runs, "process_states", lambda *_: [state])
        assert one(runs.swarms()).level == "ok"
        held.send_signal(signal.SIGSTOP)
        while psutil.Process(held.pid).status() != psutil.STATUS_STOPPED:
            time.sleep(0.01)
        _, found = runs.swarms()
        held.send_signal(signal.SIGCONT)
        held.communicate()
    assert found.level == "warning"
    assert found.text == f"a of red is suspended (process {held.pid})"
    assert found.way_out == f"`kill -CONT {held.pid}` lets it continue"


def test_a_swarm_that_has_crashed_and_its_processes_are_reported():
    folder = RunFolder.of_swarm("red")
    folder.prepare()
    folder.write(
        RunRecord("red", "r.yaml", 7, "LOCALHOST", ("a",), True, 1, "s", "red-1"), register=True
    )
    with subprocess.Popen(
        [sys.executable, "-c", "input()"],
        stdin=subprocess.PIPE,
        env={**os.environ, MARK: str(folder.path)},
    ) as left:
        crashed = one(runs.swarms())
        (lost,) = [f for f in runs.leftovers() if str(left.pid) in f.text]
        left.communicate()
    assert crashed.level == "warning"
    assert f"red has ended without being stopped ({folder.path})" in crashed.text
    assert "`hitab down red`" in crashed.way_out
    assert lost.text == f"processes {left.pid} of a killed run in {folder.path}"
    assert f"`hitab down --run-dir {folder.path}`" in lost.way_out


def test_what_hinders_the_agents_of_a_swarm_is_reported(alone, monkeypatch):
    assert list(runs.faults()) == [], "no swarm is up"
    folder = RunFolder.of_swarm("red")
    folder.prepare()
    record = RunRecord("red", "r.yaml", alone, "LOCALHOST", ("a", "b"), True, 1, "s", "red-1")
    folder.write(record, register=True)
    monkeypatch.setattr(RunFolder, "supervisor", lambda *_: object())

    def say(link: RosLink, agent: str, *faults: str) -> None:
        publisher = link.node.create_publisher(AgentStatus, f"/{agent}/status", qos.LATCHED)
        publisher.publish(AgentStatus(agent=agent, swarm="red-1", faults=faults))

    with RosLink(alone) as link:
        say(link, "a", "nothing heard on /scan")
        monkeypatch.setattr(runs, "FOUND_S", 0.5)
        mute, *_ = runs.faults()
        assert mute.level == "warning"
        assert mute.text.endswith("b of red did not answer within 0.5 s")
        monkeypatch.setattr(runs, "FOUND_S", 60.0)
        say(link, "b")
        found = one(runs.faults())
        assert (found.level, found.text) == ("warning", "a: nothing heard on /scan")
        assert "`hitab status`" in found.way_out
        monkeypatch.setattr(runs, "LARGE_SWARM", 1)
        assert "were not asked" in one(runs.faults()).text
