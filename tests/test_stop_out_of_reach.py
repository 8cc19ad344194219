"""A stop that is given while robots are out of reach stops them when they are back.

So do groups of agents with links of their own, which halt or go on meanwhile. The machines are
network namespaces joined by veth; see `lossy_switch`.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lossy_network import LossyNetwork, shifted_clock, why_not

ROBOT, DESK, FIELD = 1, 2, 3
ANTS = ("ant_1", "ant_2")
KIND = "commander: Squad\norders: {Drive: Go, Turn: Turn, Halt: Stop}\n"
BUTTON = """
from hitab_msgs.msg import EmergencyStop
from hitab_ros import make_node, names, qos, run

def start(spinning):
    node = make_node("button")
    spinning.executor.add_node(node)
    publisher = node.create_publisher(EmergencyStop, names.EMERGENCY_STOP, qos.LATCHED)
    publisher.publish(EmergencyStop(engaged=True, by="button", reason="pressed"))

run(start)
"""
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
    """A robot's computer with its relay, a person's, who has only the command line, and a field.

    In the field is a host of robots without relays, if the test starts it.
    """

    def __init__(self, folder: Path, network: LossyNetwork) -> None:
        self.folder = folder
        self.network = network
        self.run(ROBOT, RELAY)

    def run(self, host: int, program: list[str], **environment: str) -> Path:
        """Start a program; return what it says."""
        log = self.folder / f"{len(list(self.folder.glob('*.log')))}.log"
        here = ENVIRONMENT | {"HITAB_HOME": str(self.folder / f"home_{host}")} | environment
        self.network.run(host, [sys.executable, *program], log, **here)
        return log

    def hitab(self, *arguments: str) -> Path:
        """Have the person give a command."""
        return self.run(DESK, ["-m", "hitab_cli.main", *arguments])

    def start_field(self) -> Path:
        """Start the host of the ants, of which the first halts out of reach, and their commander.

        Returns:
            What the host says.
        """
        kind = self.folder / "squad.yaml"
        kind.write_text(KIND)
        common = {"domain": "field_robots:DOMAIN", "commander": "squad"}
        common |= {"library": str(self.folder), "state_dir": str(self.folder / "state")}
        halts = {"when_out_of_reach": "halt", "out_of_reach_after": 2.0}
        roster = [
            {"name": name, "parameters": common | (halts if name == ANTS[0] else {})}
            for name in ANTS
        ]
        file = self.folder / "roster.json"
        file.write_text(json.dumps(roster))
        line = ["-m", "hitab_commander.commander_main", "--ros-args", "-r", "__ns:=/squad"]
        line += ["-p", f"domain:={kind}", "-p", f"subordinates:=[{', '.join(ANTS)}]"]
        self.run(DESK, [*line, "-p", f"state_dir:={self.folder / 'state_of_squad'}"])
        line = ["-m", "hitab_agent.host_main", "--ros-args", "-p", f"roster:={file}"]
        here = {"PYTHONPATH": str(Path(__file__).parent), "FIELD": str(self.folder)}
        return self.run(FIELD, line, **here)

    def speeds(self, ant: str) -> list[str]:
        """Return all speeds of an ant so far."""
        file = self.folder / ant
        return file.read_text().split() if file.exists() else []

    def drive(self, *speeds: str) -> bool:
        """Whether the ants drive at these speeds now."""
        return [self.speeds(ant)[-1:] for ant in ANTS] == [[speed] for speed in speeds]


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Machines]:
    """Return a robot and a person, joined."""
    with LossyNetwork(3, 0.01, 0.02) as network:
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
        ends = ("stand still", "released: ", "error: ", "performs ")
        if any(says(logs[-1], end)() for end in ends):
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


@pytest.mark.parametrize(
    "seconds", [10.0, pytest.param(40.0, marks=pytest.mark.long)], ids=lambda s: f"{s:g}s"
)
def test_during_a_cut_some_halt_and_after_it_nothing_moves_until_it_is_re_armed(
    machines: Machines, seconds: float
) -> None:
    field = machines.start_field()
    until_it_says(machines, ("squad performs Drive",), "order", "squad", "Drive")
    until_it_says(machines, ("ant_1", "ant_2", "may act"), "arm", *ANTS)
    until(lambda: machines.drive("1", "1"), field)

    machines.network.cut_off(FIELD)
    began = time.monotonic()
    order = machines.hitab("order", "squad", "Turn")
    until(says(order, "squad performs Turn"), order)
    stop = machines.hitab("stop", "--reason", "a dog")
    until(says(stop, "stand still: robot_1"), stop)  # its relay hands the stop on
    until(lambda: machines.drive("0", "1"), field)
    until(lambda: time.monotonic() - began > seconds, field)
    assert machines.drive("0", "1"), "who goes on out of reach goes on, and the other stands"

    machines.network.heal()
    until(lambda: machines.drive("0", "0"), field)
    until_it_says(machines, ("(a dog)",), "arm", ANTS[1])
    before = [machines.speeds(ant) for ant in ANTS]
    assert before[0] == ["0", "1", "0"], "it halted, and nothing has moved it since"
    assert before[1] in (["0", "1", "0"], ["0", "1", "2", "0"]), "the order may come first"
    until_it_says(machines, ("released: ", *ANTS), "go")
    until_it_says(machines, ("Turn",), "status", "--json", "-")
    assert [machines.speeds(ant) for ant in ANTS] == before, "a release moves nothing"
    until_it_says(machines, ("ant_1", "ant_2", "may act"), "arm", *ANTS)
    until(lambda: machines.drive("2", "2"), field)


@pytest.mark.parametrize("shift_s", [-3600, 3600])
def test_a_button_whose_clock_is_wrong_stops_whoever_comes_back(
    machines: Machines, shift_s: int, tmp_path: Path
) -> None:
    field = machines.start_field()
    until_it_says(machines, ("squad performs Drive",), "order", "squad", "Drive")
    until_it_says(machines, ("stand still: ", *ANTS, "robot_1"), "stop", "--reason", "earlier")
    until_it_says(machines, ("released: ", *ANTS), "go")
    until_it_says(machines, ("ant_1", "ant_2", "may act"), "arm", *ANTS)
    until(lambda: machines.drive("1", "1"), field)
    machines.network.cut_off(FIELD)
    clock = {"CLOCK_SHIFT_S": str(shift_s), "LD_PRELOAD": str(shifted_clock(tmp_path))}
    says_its_time = "import time; print(time.time())"
    told = machines.run(DESK, ["-c", says_its_time], **clock)
    until(lambda: bool(told.read_text()), told)
    assert abs(float(told.read_text()) - time.time() - shift_s) < 600.0
    machines.run(DESK, ["-c", BUTTON], **clock)
    until_it_says(machines, ("button (pressed)",), "arm", "robot_1")
    machines.network.heal()
    until(lambda: machines.drive("0", "0"), field)
    until_it_says(machines, ("button (pressed)",), "arm", ANTS[1])
