"""Measures how soon a base that holds its last Twist stands still, once its agent dies.

An agent turns a robot, and at a random moment is killed (SIGKILL) or hangs (SIGSTOP); or the
emergency stop is engaged by somebody who is connected already. The time runs until the base has
zero for good. The base is a subscription in this process, which remembers when each Twist came.

    scripts/python benchmarks/robot_stop.py --trials 20
"""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from statistics import mean, stdev
from typing import Annotated, Any

import typer
from geometry_msgs.msg import Twist
from rich.console import Console
from rich.table import Table

from hitab_client import RosLink, SwarmClient
from hitab_client.domain_ids import reserved
from hitab_ros import EmergencySwitch

EXAMPLE = Path(__file__).resolve().parents[1] / "examples/diff_drive"
ROBOT = "robot_1"
SIGNALS = {"killed agent": signal.SIGKILL, "hanging agent": signal.SIGSTOP}
START_S = 60.0
HELD_S = 1.5
"""How long the base must have had zero since, s."""


class Base:
    """A base that does what it was told last, however long ago that is."""

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


def trial(link: RosLink, how: str, random_number: random.Random, environment: Any) -> float:
    """Return how long the base moved on, s."""
    with ExitStack() as stack:
        state = stack.enter_context(tempfile.TemporaryDirectory())
        command = [sys.executable, "-m", "hitab_agent.agent_main", "--ros-args"]
        command += ["-r", f"__ns:=/{ROBOT}", "-p", "domain:=diff_drive.domain:DOMAIN"]
        agent = subprocess.Popen(
            [*command, "-p", f"state_dir:={state}"], env=environment, stderr=subprocess.DEVNULL
        )
        stack.callback(agent.wait)
        stack.callback(agent.kill)
        base, agents = Base(link), SwarmClient(link, [ROBOT])
        switch = EmergencySwitch(link.node)
        agents.await_agent(ROBOT, START_S)
        agents.perform(ROBOT, "TurnLeft")
        base.until(moves=True)
        link.spin_until(lambda: False, 0.5 + random_number.random())
        began = time.monotonic()
        if how in SIGNALS:
            agent.send_signal(SIGNALS[how])
        else:
            switch.set(True, "benchmark")
        base.until(moves=False)
        stopped = base.last_change()
        switch.set(False, "benchmark")
        if how not in SIGNALS:
            base.until(moves=True)
        return stopped - began


def main(
    trials: Annotated[int, typer.Option(help="Trials of each kind.", min=2)] = 10,
    seed: Annotated[int, typer.Option(help="For the moments of the stops.")] = 1,
) -> None:
    """Measure how soon a base that holds its last Twist stands still."""
    console = Console()
    table = Table("stopped by", "trials", "mean ± s.e., s", "longest, s")
    with reserved() as domain_id:
        environment = {
            **os.environ,
            "ROS_DOMAIN_ID": str(domain_id),
            "PYTHONPATH": os.pathsep.join([str(EXAMPLE), os.environ.get("PYTHONPATH", "")]),
        }
        for how in (*SIGNALS, "emergency stop"):
            random_number = random.Random(seed)
            took = []
            for number in range(trials):
                with RosLink(domain_id) as link:
                    took.append(trial(link, how, random_number, environment))
                console.print(f"{how}, trial {number + 1} of {trials}: {took[-1]:.3f} s")
            error = stdev(took) / len(took) ** 0.5
            row = (f"{mean(took):.3f} ± {error:.3f}", f"{max(took):.3f}")
            table.add_row(how, str(trials), *row)
    console.print(table)


if __name__ == "__main__":
    typer.run(main)
