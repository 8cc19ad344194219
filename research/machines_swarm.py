"""A swarm on three machines for `machines.py`, and the program of a person who commands it."""

from __future__ import annotations

import contextlib
import json
import os
import select
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

TESTS = Path(__file__).resolve().parents[1] / "tests"
MACHINES = {"lab_1": 1, "lab_2": 2, "lab_3": 3}
CYCLES_HZ, FIELD_M, SQUAD = 10.0, 8.5, 5
START_S, LONG_S = 240.0, 120.0
MEANT = {"Work": "Forage", "Turn": "RotateLeft", "Halt": "Stop"}
DRIVEN = {"Work": "Go", "Turn": "Turn", "Halt": "Stop"}
SITUATION = ("cycle", "ago", "readings")
"""Fields of an example that tell of the world when it was shown: two runs differ in them."""

COMMANDS = ("Forward", "RotateLeft", "Stop", "Forward")

SWARM = """\
swarm: thousand
domain: foraging
world:
  kind: foraging
  factor: {factor}
  seed: 1
  parameters:
    {{foragers: {agents}, width: {side}, height: {side}, obstacles: 6, duration: 36000.0,
      small_boxes: {boxes}, renew: true}}
agents:
  forager: {{count: {agents}, start_from: foraging}}
  robot_1: {{domain: "field_robots:DOMAIN", when_out_of_reach: halt}}
  robot_2: {{domain: "field_robots:DOMAIN"}}
kinds:
  Squad: {{orders: {{Work: Forage, Turn: RotateLeft, Halt: Stop}}}}
  Drivers: {{orders: {{Work: Go, Turn: Turn, Halt: Stop}}}}
  Company: {{orders: {{Work: Work, Turn: Turn, Halt: Halt}}}}
commanders:
  squad: {{kind: Squad, commands: {{forager: {squad}}}}}
  company: {{kind: Company, commands: {{squad: {squads}}}}}
  drivers: {{kind: Drivers, commands: [robot_1, robot_2]}}
  chief: {{kind: Company, commands: [company_1, company_2, company_3, drivers]}}
machines:
  lab_1: {{runs: [world, chief, drivers, company_1]}}
  lab_2: {{runs: [company_2, robot_1, robot_2]}}
  lab_3: {{runs: [company_3]}}
"""


class Person:
    """A person's program on the first machine, which obeys lines of JSON: method and arguments."""

    def __init__(self, folder: Path) -> None:
        from hitab_msgs.msg import WorldStatus

        from hitab_client import MachineSigns, RosLink, RunFolder, Stops, SwarmClient
        from hitab_ros import names, qos

        record = RunFolder(folder).read()
        assert record is not None
        self.link = RosLink(record.domain_id)
        self.agents = SwarmClient(self.link, record.agents, identity=record.identity)
        self.stops = Stops(self.link)
        self._engaged = False
        self.signs = MachineSigns(self.link.node, "", record.identity)
        self.world = WorldStatus()
        self.cycles = self.late = 0
        self.processes = record.processes
        self.link.subscribe(
            WorldStatus, names.of_world(names.STATUS), self._hear_world, qos.LATCHED
        )

    def _hear_world(self, status: Any) -> None:
        last, self.world = self.world, status
        if status.cycle > last.cycle and status.missed_deadlines >= last.missed_deadlines:
            self.cycles += status.cycle - last.cycle
            self.late += status.missed_deadlines - last.missed_deadlines

    def serve(self) -> None:
        """Do what is asked until the input ends."""
        while True:
            while not select.select([sys.stdin], [], [], 0.0)[0]:
                self.link.spin_until(lambda: False, 0.05)
            if not (line := sys.stdin.readline()):
                return
            method, *arguments = json.loads(line)
            try:
                answer = {"value": getattr(self, method)(*arguments)}
            except Exception as error:
                answer = {"error": f"{type(error).__name__}: {error}"}
            print(json.dumps(answer), flush=True)

    def wait(self) -> int:
        """Wait until all agents and the world are there."""
        self.agents.await_agents()
        there = lambda: bool(self.world.cycle) and not self.world.missing  # noqa: E731
        if not self.link.spin_until(there, START_S):
            raise TimeoutError(f"the world misses {list(self.world.missing)[:5]}")
        return len(self.agents.statuses)

    def lateness(self) -> tuple[int, int]:
        """Return the numbers of cycles and of late answers since the last call."""
        found = self.cycles, self.late
        self.cycles = self.late = 0
        return found

    def train(self, agent: str) -> None:
        """Leave an agent with an unsaved training, performing something else."""
        from hitab_core.operations import BeginTraining, Command, Perform

        for operation in (
            BeginTraining("Unsaved", features=["Done"]),
            *map(Command, COMMANDS),
            Perform("Stop"),
        ):
            self.agents.do(agent, operation)

    def order(self, order: str) -> float:
        """Have the chief order something; return how long it took until it acknowledged, s."""
        from hitab_client import SwarmError
        from hitab_core.operations import Perform

        began = time.monotonic()
        while True:
            try:
                self.agents.do("chief", Perform(order))
                return time.monotonic() - began
            except SwarmError:
                if time.monotonic() - began > LONG_S:
                    raise

    def obey(self, order: str, without: list[str]) -> float:
        """Wait until all obey an order, except for some processes; return how long it took, s."""
        absent = {name for process in without for name in self.processes[process]}
        began = time.monotonic()

        def disobeying() -> list[str]:
            return [
                name
                for name, status in self.agents.statuses.items()
                if name not in absent
                and (status.behavior != _meant(name, order) or name in missing)
            ]

        missing = {*self.world.missing}
        while left := disobeying():
            if time.monotonic() - began > LONG_S:
                behaviors = {name: self.agents.statuses[name].behavior for name in left[:5]}
                raise TimeoutError(f"{len(left)} do not obey {order}, such as {behaviors}")
            self.link.spin_until(lambda: False, 0.05)
            missing = {*self.world.missing}
        return time.monotonic() - began

    def stop(self, engaged: bool, seconds: float) -> dict[str, str]:
        """Stop or release all; return who has not confirmed, and why."""
        from hitab_client import Stops

        if engaged is not self._engaged:  # an object is for one stop or release
            self.stops = Stops(self.link, switch=self.stops.switch)
            self._engaged = engaged
        return self.stops.switch_all([self.stops], "research", engaged=engaged, seconds=seconds)

    def confirmed(self, seconds: float) -> float:
        """Say a stop again until all have confirmed it; return how long it took, s."""
        began = time.monotonic()
        if left := self.stop(True, seconds):
            raise TimeoutError(f"not confirmed: {left}")
        return time.monotonic() - began

    def silent(self, machine: str, silent: bool = True) -> float:
        """Wait until a machine is silent, or heard again; return how long it took, s."""
        began = time.monotonic()
        reached = lambda: (machine in self.signs.silent()) is silent  # noqa: E731
        if not self.link.spin_until(reached, LONG_S, 0.05):
            raise TimeoutError(f"{machine} is {'not silent' if silent else 'silent'}")
        return time.monotonic() - began

    def arm(self) -> None:
        """Let the robots act."""
        for robot in ("robot_1", "robot_2"):
            self.stops.arm(robot, LONG_S)

    def places(self, process: str) -> dict[str, list[float]]:
        """Return where the foragers of a process are."""
        from hitab_msgs.msg import WorldState

        from hitab_ros import names, qos

        found: list[WorldState] = []
        subscription = self.link.subscribe(
            WorldState, names.of_world(names.STATE), found.append, qos.LATCHED, temporary=True
        )
        now = self.world.cycle  # the first state may be one that was kept for late subscribers
        self.link.spin_until(lambda: bool(found) and found[-1].cycle >= now, LONG_S)
        self.link.node.destroy_subscription(subscription)
        inside = {*self.processes[process]}
        return {e.name: [e.x, e.y, e.heading] for e in found[-1].entities if e.name in inside}

    def state(self, agent: str) -> dict[str, Any]:
        """Return what each agent does and knows, and the unsaved training of one."""
        found: dict[str, Any] = {
            name: {
                "mode": status.mode,
                "behavior": status.behavior,
                "order": [status.order.commander, status.order.behavior, status.order.waits],
                "library": status.library_digest,
                "training": [status.training.automaton, status.training.examples],
                "armed": status.armed,
                "faults": list(status.faults),
            }
            for name, status in self.agents.statuses.items()
        }
        found["examples"] = [
            {name: value for name, value in example.items() if name not in SITUATION}
            for example in self.examples(agent)
        ]
        return found

    def examples(self, agent: str) -> list[dict[str, Any]]:
        """Return the examples of an agent's training, as plain data."""
        from dataclasses import asdict

        return [asdict(example) for example in self._training(agent).examples]

    def _training(self, agent: str) -> Any:
        """Return the training of an agent, which this program may have to discover first."""
        from hitab_client import SwarmError

        began = time.monotonic()
        while True:
            try:
                return self.agents.training(agent)
            except SwarmError:
                if time.monotonic() - began > LONG_S:
                    raise


def _meant(name: str, order: str) -> str:
    """Return the behavior with which an agent or commander obeys an order."""
    if name.startswith("forager"):
        return MEANT[order]
    return DRIVEN[order] if name.startswith("robot") else order


class Swarm:
    """A swarm that is up on three machines, and the person's program."""

    def __init__(self, folder: Path, network: Any, agents: int, rate: float, domain: int) -> None:
        from hitab_client import RunFolder

        self.folder, self.network = folder, network
        squads = -(-agents // SQUAD)
        self.file = folder / "thousand.yaml"
        self.file.write_text(
            SWARM.format(
                agents=agents,
                factor=rate / CYCLES_HZ,
                side=max(50.0, FIELD_M * agents**0.5),
                boxes=max(5, agents // 5),
                squad=SQUAD,
                squads=-(-squads // 3),
            )
        )
        self.field = folder / "field"
        self.field.mkdir(parents=True)
        self._environment = {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET",
            "FASTRTPS_DEFAULT_PROFILES_FILE": "",
            "FASTDDS_DEFAULT_PROFILES_FILE": "",
            "FIELD": str(self.field),
            "PYTHONPATH": f"{TESTS}:{os.environ.get('PYTHONPATH', '')}",
        }
        self.runs: dict[str, Any] = {
            name: RunFolder(folder / f"home_{name}/thousand") for name in MACHINES
        }
        self.trained = f"forager_{agents}"
        self.given: list[str] = []
        self._logs = 0

    def _there(self, machine: str) -> dict[str, str]:
        home = self.folder / f"home_{machine}"
        home.mkdir(exist_ok=True)
        return {**self._environment, "HITAB_HOME": str(home)}

    def start(self, machine: str, *arguments: str) -> tuple[Any, Path]:
        """Start `hitab` on a machine; return its process and what it says."""
        self._logs += 1
        log = self.folder / f"{self._logs}.log"
        line = [sys.executable, "-m", "hitab_cli.main", *arguments]
        there = self._there(machine)
        return self.network.run(MACHINES[machine], line, log, **there), log

    def hitab(self, machine: str, *arguments: str) -> str:
        """Have `hitab` do something on a machine, and return what it says."""
        process, log = self.start(machine, *arguments)
        process.wait(START_S)
        if process.returncode:
            raise SystemExit(f"{machine}: hitab {' '.join(arguments)}: {log.read_text()}")
        return log.read_text()

    @contextlib.contextmanager
    def up(self) -> Iterator[None]:
        """Start all machines, and the person's program on the first."""
        from hitab_bringup.processes import supervision

        try:
            starts = [
                self.start(machine, "up", str(self.file), "--machine", machine)
                for machine in MACHINES
            ]
            for process, log in starts:
                if process.wait(START_S):
                    raise SystemExit(log.read_text())
            line = [sys.executable, __file__, str(self.runs["lab_1"].path)]
            self._person = subprocess.Popen(
                [*self.network.enter(1), *line],
                env={**os.environ, **self._there("lab_1")},
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
            )
            try:
                self.ask("wait")
                yield
            finally:
                self._person.kill()
                self._person.wait()
        finally:
            for run in self.runs.values():
                supervision.stop(run)

    def ask(self, method: str, *arguments: Any) -> Any:
        """Have the person's program do something."""
        self.tell(method, *arguments)
        return self.answer()

    def tell(self, method: str, *arguments: Any) -> None:
        """Have the person's program begin to do something."""
        assert self._person.stdin is not None
        self._person.stdin.write(json.dumps([method, *arguments]) + "\n")
        self._person.stdin.flush()

    def answer(self) -> Any:
        """Return the answer of the person's program."""
        assert self._person.stdout is not None
        answer = json.loads(self._person.stdout.readline() or '{"error": "it has ended"}')
        if "error" in answer:
            raise SystemExit(f"the person's program: {answer['error']}")
        return answer["value"]

    def order(self, order: str) -> None:
        """Give an order, and remember it."""
        self.ask("order", order)
        self.given.append(order)

    def obey(self, order: str, without: tuple[str, ...] = ()) -> float:
        """Give an order; return how long it took until all obeyed, s."""
        began = time.monotonic()
        self.order(order)
        self.ask("obey", order, without)
        return time.monotonic() - began

    def running(self) -> dict[tuple[str, str], int]:
        """Return the processes that run, other than those of robots, with their numbers."""
        from hitab_client.runs.run_processes import process_states

        return {
            (machine, state["name"]): state["pid"]
            for machine, run in self.runs.items()
            for state in process_states(run.read())
            if state["statename"] == "RUNNING" and not state["name"].startswith("robot")
        }

    def speeds(self) -> dict[str, list[str]]:
        """Return all speeds of the robots so far."""
        return {file.name: file.read_text().split() for file in sorted(self.field.iterdir())}


def states(run: Any) -> dict[str, str]:
    """Return the states of a machine's processes, by name."""
    from hitab_client.runs.run_processes import process_states

    return {state["name"]: state["statename"] for state in process_states(run.read())}


def until(condition: Callable[[], bool], what: str, seconds: float = LONG_S) -> float:
    """Wait until a condition holds; return how long it took, s."""
    began = time.monotonic()
    while not condition():
        if time.monotonic() - began > seconds:
            raise SystemExit(f"not in {seconds:g} s: {what}")
        time.sleep(0.05)
    return time.monotonic() - began


if __name__ == "__main__":
    Person(Path(sys.argv[1])).serve()
