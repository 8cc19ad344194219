"""`hitab world step` ends when the world has been stepped; Ctrl-C stops the world, too."""

from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from hitab_msgs.msg import WorldStatus
from typer.testing import CliRunner

from hitab_cli.main import make_app
from hitab_cli.verbs.swarm import world_verbs as verb
from hitab_client import WorldClient
from hitab_ros.call import Caller, blocking


class World:
    """A world at cycle 100 that is interrupted after some cycles, as Ctrl-C does."""

    def __init__(self, interrupted_after: int) -> None:
        self.cycle, self.last, self.left = 100, 100, interrupted_after
        self.status = None
        self.link = Caller(SimpleNamespace())

    def wait(self) -> WorldStatus:
        return WorldStatus()

    @blocking
    async def control(self, action: str, cycles: int = 0) -> SimpleNamespace:
        self.last = self.cycle + cycles
        return SimpleNamespace(cycle=self.last)

    step = WorldClient.step

    @blocking
    async def state_at(
        self, cycle: int, seconds: float = 10.0, stopped: object = None
    ) -> SimpleNamespace:
        if self.cycle < cycle <= self.last:
            if not self.left:
                raise KeyboardInterrupt
            self.left -= 1
            self.cycle += 1
        return SimpleNamespace(cycle=self.cycle, episode=3)


@pytest.fixture
def stepped(monkeypatch):
    """Return a function that steps a `World`, and the world."""

    def step(cycles: int, interrupted_after: int):
        world = World(interrupted_after)

        @contextmanager
        def connection(swarm):
            yield SimpleNamespace(world=world)

        monkeypatch.setattr(verb, "connection", connection)
        return CliRunner().invoke(make_app(), ["world", "step", str(cycles)]), world

    return step


def test_ctrl_c_pauses_the_world_and_says_where(stepped):
    result, world = stepped(500, 3)
    assert result.exit_code == 130
    assert result.stdout == ""
    assert "the world is paused at cycle 103" in result.stderr
    assert world.last == world.cycle == 103
