"""Measures how soon a robot stands still, for each cause of a stop.

An agent turns a robot whose base holds its last Twist, and at a random moment it, or its relay, is
killed (SIGKILL) or hangs (SIGSTOP); its sensors fall silent; or somebody who is connected already
engages the emergency stop, with a publisher that latches or with one that does not. The time runs
until the base has zero for good. The base is a subscription in this process, which remembers when
each Twist came. Another agent has but an action: its robot flies until the server, in this
process, is asked to cancel the goal.

Then the cause is ended and nothing may move until the robot is re-armed; a robot that does is
counted. All is measured on a machine that does nothing else, and beside a busy loop per core.

    scripts/python research/robot_stop.py --trials 20
"""

from __future__ import annotations

import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from statistics import median
from typing import Annotated, Any

import psutil  # type: ignore[import-untyped]
import typer
from geometry_msgs.msg import Twist
from hitab_msgs.action import Perform
from hitab_msgs.msg import EmergencyStop
from rclpy.action import ActionServer, CancelResponse
from rclpy.task import Future
from rich.console import Console
from rich.table import Table

from hitab_client import RosLink, Stops, SwarmClient, SwarmError
from hitab_client.connecting.domain_ids import reserved
from hitab_core.operations import BeginTraining, Command
from hitab_core.operations import Perform as Performance
from hitab_ros import names

EXAMPLE = Path(__file__).resolve().parents[1] / "examples/diff_drive"
ROBOT = "robot_1"
CAUSES = (
    "agent killed",
    "agent hangs",
    "relay killed",
    "relay hangs",
    "sensors silent, in training",
    "sensors silent, on its way to a place",
    "emergency stop, latched",
    "emergency stop, volatile",
    "flies, agent killed",
    "flies, agent hangs",
    "flies, agent hangs in an emergency",
)
FLIES = "flies, "
BUSY = "while True: pass"
FLYING = """
from hitab_core import ActionBehavior, Domain
from hitab_core.operations import BeginTraining, Command, Perform
from hitab_robots import Drive, Robot

FLY = ActionBehavior("Fly", action_type="hitab_msgs/action/Perform", action="fly")
DRONE = Robot((), Drive(max_velocity=(0.0, 0.0, 0.0)))
DOMAIN = Domain.of(
    "drone", "1", DRONE, behaviors=[FLY], features=[], link="hitab_robots:RobotLink"
)
"""
START_S = 60.0
HELD_S = 1.5
"""How long the base must have had zero since, s."""


class Base:
    """A base that obeys its last velocity, however old it is."""

    def __init__(self, link: RosLink) -> None:
        self.link = link
        self.told: list[tuple[float, bool]] = []  # when, and whether to move
        link.node.create_subscription(Twist, f"/{ROBOT}/cmd_vel", self._take, 100)

    def _take(self, velocity: Twist) -> None:
        moves = velocity.linear.x != 0.0 or velocity.angular.z != 0.0
        self.told.append((time.monotonic(), moves))

    @property
    def moves(self) -> bool:
        """Whether it moves."""
        return bool(self.told) and self.told[-1][1]

    def until(self, moves: bool) -> None:
        """Wait until it moves, or stands still for good."""

        def done() -> bool:
            settled = time.monotonic() - self.last_change() >= (0.0 if moves else HELD_S)
            return self.moves is moves and settled

        if not self.link.spin_until(done, START_S, 0.01):
            raise SystemExit(f"the base does {'not move' if moves else 'not stand still'}")

    def last_change(self) -> float:
        """Return when it began to do what it does."""
        began = self.told[-1][0] if self.told else 0.0
        for when, moves in reversed(self.told):
            if moves is not self.moves:
                break
            began = when
        return began


class Drone(Base):
    """A robot that flies as long as the server of its action has a goal."""

    def __init__(self, link: RosLink) -> None:
        self.link = link
        self.told = []
        self._server = ActionServer(
            link.node, Perform, f"/{ROBOT}/fly", self._fly, cancel_callback=self._cancel
        )

    async def _fly(self, goal: Any) -> None:
        self.told.append((time.monotonic(), True))
        await Future()

    def _cancel(self, goal: Any) -> CancelResponse:
        self.told.append((time.monotonic(), False))
        return CancelResponse.ACCEPT


def trial(
    link: RosLink, how: str, random_number: random.Random, environment: Any
) -> tuple[float, bool]:
    """Return how long the base moved on, s, and whether it moved again by itself."""
    with ExitStack() as stack:
        state = stack.enter_context(tempfile.TemporaryDirectory())

        def start(module: str, *parameters: str) -> psutil.Process:
            command = [sys.executable, "-m", module, "--ros-args", "-r", f"__ns:=/{ROBOT}"]
            command += [word for parameter in parameters for word in ("-p", parameter)]
            process = psutil.Popen(command, env=environment, stderr=subprocess.DEVNULL)
            stack.callback(end, process)
            return process

        def start_agent() -> psutil.Process:
            domain = "flying:DOMAIN" if flies else "diff_drive.domain:DOMAIN"
            return start(
                "hitab_agent.agent_main",
                *(f"domain:={domain}", f"state_dir:={state}", "swarm:=benchmark"),
            )

        flies = how.startswith(FLIES)
        sensors = start("diff_drive.simulated_robot")
        agent = start_agent()
        base, agents = Drone(link) if flies else Base(link), SwarmClient(link, [ROBOT])
        stops = Stops(link)
        plain = link.node.create_publisher(EmergencyStop, names.EMERGENCY_STOP, 10)
        agents.await_agent(ROBOT, START_S)
        arm(stops, link)
        if flies:
            agents.do(ROBOT, Performance("Fly"))
        elif how == "sensors silent, on its way to a place":
            agents.do(ROBOT, Performance("DriveTo(goal)"))
        else:
            agents.do(ROBOT, BeginTraining("Turn", features=["RangeAhead"]))
            until_obeyed(agents, link)
        deadline = time.monotonic() + START_S
        while not base.moves and time.monotonic() < deadline:
            link.spin_until(lambda: base.moves, 2.0)
            arm(stops, link)  # once more, if it has stopped meanwhile
        link.spin_until(lambda: False, 0.5 + random_number.random())
        relay = next(iter(agent.children()), agent)
        began = time.monotonic()
        match how.removeprefix(FLIES):
            case "agent killed":
                agent.kill()
            case "agent hangs":
                agent.suspend()
            case "agent hangs in an emergency":
                agent.suspend()
                stops.switch.set(True, "benchmark")
            case "relay killed":
                relay.kill()
            case "relay hangs":
                relay.suspend()
            case "sensors silent, in training" | "sensors silent, on its way to a place":
                sensors.suspend()
            case "emergency stop, latched":
                stops.switch.set(True, "benchmark")
            case "emergency stop, volatile":
                plain.publish(EmergencyStop(engaged=True, by="benchmark"))
        base.until(moves=False)
        stopped = base.last_change()
        match how.removeprefix(FLIES):
            case "agent killed":
                with suppress(psutil.NoSuchProcess):
                    relay.wait()
                start_agent()
            case "agent hangs" | "agent hangs in an emergency":
                agent.resume()
            case "sensors silent, in training" | "sensors silent, on its way to a place":
                sensors.resume()
        stops.switch.set(False, "benchmark")
        link.spin_until(lambda: False, 3.0)
        return stopped - began, base.last_change() != stopped or base.moves


def end(process: psutil.Process) -> None:
    """End a process and its relay, which would outlive it, if they still are there."""
    with suppress(psutil.NoSuchProcess):
        for one in (process, *process.children()):  # it would start its relay again
            one.kill()
            one.wait()


def until_obeyed(agents: SwarmClient, link: RosLink) -> None:
    """Command it to turn; it is refused until the scanner has said something."""
    deadline = time.monotonic() + START_S
    while True:
        try:
            agents.do(ROBOT, Command("TurnLeft"))
            return
        except SwarmError:
            if time.monotonic() > deadline:
                raise
            link.spin(0.1)


def arm(stops: Stops, link: RosLink) -> None:
    """Let the robot act, as soon as nothing speaks against it."""
    deadline = time.monotonic() + START_S
    while True:
        try:
            return stops.arm(ROBOT, START_S)
        except SwarmError:
            if time.monotonic() > deadline:
                raise
            link.spin(0.1)


def main(
    trials: Annotated[int, typer.Option(help="Trials of each kind.", min=1)] = 20,
    seed: Annotated[int, typer.Option(help="For the moments of the stops.")] = 1,
    only: Annotated[str, typer.Option(help="Only causes that contain this.")] = "",
    idle: Annotated[bool, typer.Option(help="Measure on a machine that is idle.")] = True,
    busy: Annotated[bool, typer.Option(help="Measure beside a busy loop per core.")] = True,
) -> None:
    """Measure how soon a robot stands still."""
    console = Console()
    table = Table("stopped by", "machine", "trials", "median, s", "worst, s", "moved again")
    with reserved() as domain_id, tempfile.TemporaryDirectory() as modules:
        (Path(modules) / "flying.py").write_text(FLYING, encoding="utf-8")
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "PYTHONPATH": os.pathsep.join(
                [str(EXAMPLE), modules, os.environ.get("PYTHONPATH", "")]
            ),
        }
        for how in filter(lambda how: only in how, CAUSES):
            for machine in ["idle"] * idle + ["busy"] * busy:
                random_number = random.Random(seed)
                took, again = [], 0
                for number in range(trials):
                    with beside_loops(machine == "busy"), RosLink(domain_id) as link:
                        seconds, moved_again = trial(link, how, random_number, environment)
                    took.append(seconds)
                    again += moved_again
                    told = f"{how}, {machine}, trial {number + 1} of {trials}"
                    console.print(f"{told}: {seconds:.3f} s")
                figures = (f"{median(took):.3f}", f"{max(took):.3f}", str(again))
                table.add_row(how, machine, str(trials), *figures)
    console.print(table)


@contextmanager
def beside_loops(busy: bool) -> Iterator[None]:
    """Keep each core busy meanwhile, if asked to."""
    count = len(os.sched_getaffinity(0)) if busy else 0
    loops = [psutil.Popen([sys.executable, "-c", BUSY]) for _ in range(count)]
    try:
        yield
    finally:
        for loop in loops:
            end(loop)


if __name__ == "__main__":
    typer.run(main)
