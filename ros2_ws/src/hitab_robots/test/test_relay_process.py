"""How the relay of a robot is started."""

import subprocess
import sys
import time
from types import SimpleNamespace

import psutil
import pytest
from rclpy.parameter import Parameter

from hitab_robots import Drive
from hitab_robots.relay import relay_process as started_by
from hitab_robots.relay.process_state import waits_for_cpu_or_disk
from hitab_robots.settings import RelaySettings
from hitab_ros import GuardedNode
from hitab_ros.testing import context_of_its_own

SECONDS = 60.0


@pytest.fixture
def command_of(monkeypatch):
    """Return the command line of the relay that an agent with some parameters starts."""
    started = []
    popen = SimpleNamespace(Popen=lambda command, **_: started.append(command), DEVNULL=None)
    monkeypatch.setattr(started_by, "subprocess", popen)

    def start(*ros_args, **parameters):
        with context_of_its_own() as context:
            node = GuardedNode(
                "agent",
                namespace="/robot_1",
                context=context,
                cli_args=["--ros-args", *ros_args],
                parameter_overrides=[Parameter(k, value=v) for k, v in parameters.items()],
            )
            node.settings = SimpleNamespace(state_dir="", swarm="")
            started_by.RelayProcess(node, RelaySettings(Drive()), "odom")
            node.destroy_node()
        return " ".join(started.pop())

    return start


def test_a_relay_takes_the_simulated_clock_of_its_agent(command_of):
    assert "use_sim_time" not in command_of()
    command = command_of("-r", "/clock:=/left/clock", use_sim_time=True)
    assert "-p use_sim_time:=true -r /clock:=/left/clock" in command
    assert "-r cmd_vel:=/robot_1/cmd_vel" in command


def test_a_process_does_not_hang_while_any_of_its_threads_works():
    """Its main thread sleeps until the one that wakes it gets a CPU."""
    program = "import threading; threading.Thread(target={}).start(); threading.Event().wait()"
    for target, works in (("lambda: all(iter(lambda: 1, 0))", True), ("input", False)):
        command = [sys.executable, "-c", program.format(target)]
        with subprocess.Popen(command, stdin=subprocess.PIPE) as process:
            there, deadline = psutil.Process(process.pid), time.monotonic() + SECONDS
            try:
                while not (
                    there.num_threads() == 2
                    and there.status() == psutil.STATUS_SLEEPING
                    and waits_for_cpu_or_disk(process.pid) == works
                ):
                    assert time.monotonic() < deadline
            finally:
                process.kill()
