"""A stop that is given while robots are out of reach stops them when they are back.

The machines are network namespaces joined by veth; see `lossy_switch`.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lossy_network import LossyNetwork, why_not

ROBOT, DESK = 1, 2
RELAY = ["-m", "hitab_robots.relay.velocity_relay", "--ros-args", "-r", "__ns:=/robot_1"]
ENVIRONMENT = {
    "ROS_DOMAIN_ID": "7",
    "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
    # The namespaces share memory, as machines do not.
    "FASTDDS_BUILTIN_TRANSPORTS": "UDPv4",
    "FASTRTPS_DEFAULT_PROFILES_FILE": str(Path(__file__).with_name("impatient_dds.xml")),
}

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())


class Machines:
    """A robot's computer with its relay, and a person's, who has only the command line."""

    def __init__(self, folder: Path, network: LossyNetwork) -> None:
        self.folder = folder
        self.network = network
        self.run(ROBOT, RELAY)

    def run(self, host: int, program: list[str]) -> Path:
        """Start a program; return what it says."""
        log = self.folder / f"{len(list(self.folder.glob('*.log')))}.log"
        here = ENVIRONMENT | {"HITAB_HOME": str(self.folder / f"home_{host}")}
        self.network.run(host, [sys.executable, *program], log, **here)
        return log

    def hitab(self, *arguments: str) -> Path:
        """Have the person give a command."""
        return self.run(DESK, ["-m", "hitab_cli.main", *arguments])


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Machines]:
    """Return a robot and a person, joined."""
    with LossyNetwork(2, 0.01, 0.02) as network:
        yield Machines(tmp_path, network)


def says(log: Path, *texts: str) -> Callable[[], bool]:
    """Return whether a program has said all of this."""
    return lambda: all(text in log.read_text() for text in texts)


def until(condition: Callable[[], bool], log: Path) -> None:
    """Wait until a condition holds."""
    deadline = time.monotonic() + 90.0
    while not condition():
        assert time.monotonic() < deadline, log.read_text()
        time.sleep(0.05)


def until_it_says(machines: Machines, texts: tuple[str, ...], *arguments: str) -> None:
    """Give a command again and again until it says this: who is there is found in time."""
    logs = [machines.hitab(*arguments)]

    def said() -> bool:
        if says(logs[-1], *texts)():
            return True
        if any(says(logs[-1], end)() for end in ("stand still", "released: ", "error: ")):
            logs.append(machines.hitab(*arguments))
        return False

    until(said, logs[-1])


def test_a_stop_during_a_cut_is_obeyed_when_the_link_heals(machines: Machines) -> None:
    until_it_says(machines, ("stand still: robot_1",), "stop", "--reason", "first")
    until_it_says(machines, ("released: robot_1",), "go")
    machines.network.cut_off(ROBOT)
    stop = machines.hitab("stop", "--reason", "second")
    until(says(stop, "not confirmed: no node answers", "or Ctrl-C"), stop)
    machines.network.heal()
    until(says(stop, "stand still: robot_1"), stop)
    until_it_says(machines, ("robot_1 may not act again", "(second)"), "arm", "robot_1")


def test_a_stop_that_a_program_near_by_has_heard_outlasts_its_sender(machines: Machines) -> None:
    machines.run(DESK, [*RELAY[:-1], "__ns:=/robot_2"])  # any that hands on what it hears
    until_it_says(machines, ("stand still: robot_1, robot_2",), "stop", "--wait", "10")
    until_it_says(machines, ("released: robot_1, robot_2",), "go")
    machines.network.cut_off(ROBOT)
    stop = machines.hitab("stop", "--reason", "second", "--wait", "10")
    until(says(stop, "stand still: robot_2"), stop)
    machines.network.heal()
    until_it_says(machines, ("robot_1 may not act again", "(second)"), "arm", "robot_1")
