"""A robot that was taught to go to a place with two commands, as docs/your-own-robot.md shows."""

import math
import random
import sys
from pathlib import Path
from typing import Any

import pytest

from hitab_core import Agent, BehaviorLibrary, Term
from hitab_core.domain import Domain, load_domain
from hitab_core.training import Curriculum

EXAMPLE = Path(__file__).parents[1] / "examples/diff_drive"
GOAL = (1.5, -0.75)  # m
PERIOD = 0.1  # s
NEAR = 0.2  # m
SECONDS = 60.0


@pytest.fixture
def domain(monkeypatch: Any) -> Domain:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    yield load_domain("diff_drive.domain:DOMAIN")
    for name in [name for name in sys.modules if name.partition(".")[0] == "diff_drive"]:
        del sys.modules[name]


class Moving:
    """A robot that moves as its agent says, in a room without walls."""

    def __init__(self, agent: Agent, x: float, y: float, heading: float) -> None:
        self.agent, self.x, self.y, self.heading = agent, x, y, heading

    @property
    def distance(self) -> float:
        return math.hypot(GOAL[0] - self.x, GOAL[1] - self.y)

    def perceive(self) -> None:
        cycle = self.agent.cycle + 1
        values = {
            "time": cycle * PERIOD, "odom.x": self.x, "odom.y": self.y,
            "odom.heading": math.remainder(self.heading, math.tau),
            "scan.ahead.range": 6.0, "scan.around.range": 1.0, "scan.around.bearing": 0.5,
        }  # fmt: skip
        names = self.agent.domain.body.values
        self.agent.sense([values.get(name, 0.0) for name in names], [], cycle, cycle * PERIOD)

    def step(self) -> None:
        self.perceive()
        self.agent.tick()
        action, _ = self.agent.body.act()
        ahead, _, turn = action or (0.0, 0.0, 0.0)
        self.heading += turn * PERIOD
        self.x += ahead * math.cos(self.heading) * PERIOD
        self.y += ahead * math.sin(self.heading) * PERIOD


def test_a_robot_arrives_at_a_place_from_ten_random_starts(domain, tmp_path):
    agent = Agent("ann", domain, BehaviorLibrary(tmp_path / "library", domain), tmp_path)
    agent.begin(
        Curriculum("GoTo", (Term("Near", ("A",)),), parameters=("A",), arguments=("goal",))
    )
    robot = Moving(agent, 0.0, 0.0, 0.0)
    robot.perceive()
    agent.command(Term("DriveTo", ("A",)))
    for _ in range(100):  # a late command: it stands there already
        robot.step()
    robot.perceive()
    agent.command(Term("Done"))
    robot.step()
    agent.save()
    chance = random.Random(7)
    for _ in range(10):
        robot = Moving(
            agent, chance.uniform(-3, 3), chance.uniform(-3, 3), chance.uniform(-math.pi, math.pi)
        )
        agent.perform(Term("GoTo", ("goal",)))
        for _ in range(round(SECONDS / PERIOD)):
            robot.step()
            if "Done" in agent.raised:
                break
        assert "Done" in agent.raised
        assert robot.distance <= NEAR
