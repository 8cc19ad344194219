"""A swarm on several machines, each started with `hitab up --machine`, or all at once by ssh.

The machines are network namespaces joined by veth; see `lossy_switch`. The `ssh` of these tests is
a stub that runs the command in the namespace of its destination, in a terminal as `ssh -tt` does.
"""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from lossy_network import LossyNetwork, why_not

from hitab_bringup.processes import supervision
from hitab_client import RunFolder

SWARM = """\
swarm: field
domain: foraging
world: {kind: foraging, parameters: {foragers: 9}}
start_from: foraging
behavior: Forage
agents:
  forager: {count: 9}
kinds: {Squad: kinds/squad.yaml}
commanders:
  squad: {kind: Squad, commands: {forager: 3}}
machines:
  lab_1: {runs: [world, squad_1]}
  lab_2: {runs: squad_2, ssh: ann@lab2}
  lab_3: {runs: squad_3, ssh: lab3}
"""
FORAGERS = [f"forager_{i}" for i in range(1, 10)]
KIND = "commander: Squad\norders: {Work: Forage, Rest: nothing}\n"
HOSTS = {"lab_1": 1, "lab_2": 2, "lab_3": 3}
DESTINATIONS = {"ann@lab2": "lab_2", "lab3": "lab_3"}
STUB_SSH = """\
import json, os, pty, sys
*options, destination, command = sys.argv[1:]
assert options == ["-tt", "-o", "BatchMode=yes", "-o", "LogLevel=ERROR"], options
enter = json.loads(os.environ["STUB_SSH"]).get(destination)
if enter is None:
    print("Host key verification failed.", file=sys.stderr)
    sys.exit(255)
home = {name: value for name, value in os.environ.items() if not name.startswith("ROS_")}
os.environ.clear()
os.environ.update(home, HITAB_HOME=enter["home"])
os.chdir(enter["home"])
sys.exit(os.waitstatus_to_exitcode(pty.spawn([*enter["line"], "sh", "-c", command])))
"""

OBSERVER = """\
import sys
from hitab_client import RosLink, WorldClient
with RosLink() as link:
    world, began, still = WorldClient(link), {}, set(sys.argv[1:])
    def all_have_moved():
        for entity in world.state.entities if world.state else ():
            place = (entity.x, entity.y)
            if began.setdefault(entity.name, place) != place:
                still.discard(entity.name)
        return not still
    link.spin_until(all_have_moved, 60.0)
    print("all have moved" if not still else f"no move of {still}")
"""
"""Program that looks at the world until some entities have moved."""

pytestmark = pytest.mark.skipif(bool(why_not()), reason=why_not())
enters_namespaces = pytest.mark.skipif(
    os.geteuid() != 0, reason="the stub of ssh enters other namespaces from one: be root"
)


class Machines:
    """Three computers, the first with the swarm file."""

    def __init__(self, folder: Path, network: LossyNetwork) -> None:
        self.folder, self.network = folder, network
        self.file = folder / "home_lab_1" / "field.yaml"
        for machine in HOSTS:
            self.home(machine).mkdir()
        (self.file.parent / "kinds").mkdir()
        (self.file.parent / "kinds" / "squad.yaml").write_text(KIND)
        self.file.write_text(SWARM)
        self._programs = folder / "programs"
        self._programs.mkdir()
        hitab = f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m hitab_cli.main "$@"\n'
        stub = (
            f'#!/bin/sh\nexec {shlex.join([sys.executable, str(folder / "stub_ssh.py")])} "$@"\n'
        )
        (folder / "stub_ssh.py").write_text(STUB_SSH)
        for name, text in (("hitab", hitab), ("ssh", stub)):
            (self._programs / name).write_text(text)
            (self._programs / name).chmod(0o755)

    def home(self, machine: str) -> Path:
        return self.folder / f"home_{machine}"

    def hitab(self, machine: str, *arguments: str) -> Path:
        """Give a command on a machine; return what it says."""
        return self.run(machine, "-m", "hitab_cli.main", *arguments)[1]

    def run(self, machine: str, *arguments: str) -> tuple[subprocess.Popen[bytes], Path]:
        """Start Python on a machine; return the process and what it says."""
        log = self.folder / f"{len([*self.folder.glob('*.log')])}.log"
        inside = {
            destination: {"home": str(self.home(name)), "line": self.network.enter(HOSTS[name])}
            for destination, name in DESTINATIONS.items()
        }
        variables = {
            "HITAB_HOME": str(self.home(machine)),
            "ROS_DOMAIN_ID": "25",
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
            "PATH": f"{self._programs}:{os.environ['PATH']}",
            "PYTHONPATH": f"{self._programs}:{os.environ.get('PYTHONPATH', '')}",
            "STUB_SSH": json.dumps(inside),
        }
        line = [sys.executable, *arguments]
        return self.network.run(HOSTS[machine], line, log, **variables), log

    def all_act(self, machine: str) -> None:
        """Wait until all foragers have moved, as seen from a machine."""
        log = self.run(machine, "-c", OBSERVER, *FORAGERS)[1]
        until(says(log, "all have moved"), log)

    def seen(self, machine: str) -> set[str]:
        """Return the agents that are heard on a machine and perform something."""
        log = self.hitab(machine, "status", "--json", "-")
        until(lambda: log.read_text().rstrip().endswith("}"), log)
        text = log.read_text()
        agents = json.loads(text[text.index("{") :])["agents"]
        return {agent["agent"] for agent in agents if agent["active_path"]}

    def stop(self) -> None:
        """Stop everything."""
        for machine in HOSTS:
            supervision.stop(RunFolder(self.home(machine) / "field"))


@pytest.fixture
def machines(tmp_path: Path) -> Iterator[Machines]:
    with LossyNetwork(3, 0.005, 0.0) as network:
        three = Machines(tmp_path, network)
        yield three
        three.stop()


def until(condition: Callable[[], bool], *logs: Path) -> None:
    """Wait until a condition holds."""
    deadline = time.monotonic() + 120.0
    while not condition():
        assert time.monotonic() < deadline, "\n".join(log.read_text() for log in logs)
        time.sleep(0.05)


def says(log: Path, *texts: str) -> Callable[[], bool]:
    return lambda: all(text in log.read_text() for text in texts)


def test_three_machines_join_one_swarm_and_two_get_its_file_from_the_first(machines: Machines):
    first = machines.hitab("lab_1", "up", str(machines.file), "--machine", "lab_1")
    others = [
        machines.hitab(name, "up", "field", "--machine", name) for name in ("lab_2", "lab_3")
    ]
    until(says(first, "lab_1 of field is up: 4 agents and a world in ROS domain 25"), first)
    for name, log in zip(("lab_2", "lab_3"), others, strict=True):
        until(says(log, f"{name} of field is up: 4 agents in ROS domain 25"), first, log)
    sent = machines.home("lab_2") / "field" / "description"
    assert (sent / "field.yaml").read_text() == SWARM
    assert (sent / "kinds" / "squad.yaml").read_text() == KIND
    for name in HOSTS:
        until(lambda name=name: machines.seen(name) == {*FORAGERS})
    machines.all_act("lab_3")

    again = machines.hitab("lab_3", "up", "field", "--machine", "lab_2")
    until(says(again, 'swarm "field" is already up'), again)
    other = str(machines.folder / "other")
    again = machines.hitab("lab_3", "up", "field", "--machine", "lab_2", "--run-dir", other)
    until(says(again, "lab_2 of swarm field is already up, on another computer"), again)

    supervision.stop(RunFolder(machines.home("lab_3") / "field"))
    changed = machines.home("lab_3") / "field.yaml"
    changed.write_text(SWARM.replace("Squad: kinds/squad.yaml", "Squad: {orders: {Halt: Stop}}"))
    refused = machines.hitab("lab_3", "up", str(changed), "--machine", "lab_3")
    until(says(refused, "runs another description of swarm field (digest", "lab_3"), refused)


@enters_namespaces
def test_one_command_starts_all_by_ssh_and_each_line_names_its_machine(machines: Machines):
    up = machines.hitab("lab_1", "up", str(machines.file), "--all")
    until(says(up, "lab_1 of field is up: 4 agents and a world in ROS domain 25"), up)
    for name in ("lab_2", "lab_3"):
        assert says(up, f"{name}: {name} of field is up: 4 agents in ROS domain 25")()
    assert "not up yet: lab" not in up.read_text().rpartition("lab_1 of field is up")[2]
    machines.all_act("lab_2")


@enters_namespaces
def test_ctrl_c_ends_the_starts_on_all_machines(machines: Machines):
    process, log = machines.run("lab_1", "-m", "hitab_cli.main", "up", str(machines.file), "--all")
    until(says(log, "lab_2: waiting for a machine of swarm field"), log)
    process.send_signal(signal.SIGINT)
    until(lambda: process.poll() is not None, log)
    assert process.returncode == 130, log.read_text()
    assert "lab_2: interrupted" in log.read_text()
    for name in HOSTS:
        assert not RunFolder(machines.home(name) / "field").processes()
