"""Whatever goes wrong while a lesson is played, the world is left as it was."""

import signal
from collections.abc import Callable

import pytest

from hitab_client.errors import SwarmError
from hitab_client.showing.world_as_it_was import as_it_was
from hitab_client.terminal.interruptions import handle_interruptions


@pytest.fixture
def running(keepers):
    """A world that runs at 50 times real time, and is paused afterwards."""
    keepers.world.control("pace", pace="realtime", factor=50.0)
    keepers.world.control("resume")
    assert keepers.link.spin_until(lambda: how_it_runs(keepers) == AS_IT_WAS, 10)
    yield keepers
    keepers.world.control("pause")


AS_IT_WAS = ("running", "realtime", 50.0)


def how_it_runs(keepers) -> tuple[str, str, float]:
    status = keepers.world.status
    return status.mode, status.pace, status.factor


def is_as_it_was(keepers) -> bool:
    return keepers.link.spin_until(lambda: how_it_runs(keepers) == AS_IT_WAS, 10)


def changed(keepers, then: Callable[[], object]) -> None:
    """Change how the world runs, then do something else."""
    world = keepers.world
    with as_it_was(world):
        world.control("pace", pace="lockstep")
        world.control("pause")
        assert world.link.spin_until(lambda: world.status.mode == "paused", 10)
        then()


@pytest.fixture
def handled():
    """Ctrl-C is handled as in the command."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    handle_interruptions()
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def in_the_next_request(monkeypatch, world, then: Callable[[], object]) -> None:
    """Do something when the world is asked for the next change."""
    control = world.control

    def asked(*arguments, **more):
        monkeypatch.setattr(world, "control", control)
        then()
        return control(*arguments, **more)

    monkeypatch.setattr(world, "control", asked)


@pytest.mark.usefixtures("handled")
def test_ctrl_c_while_it_is_handed_back_is_obeyed_afterwards(running, monkeypatch):
    # Without putting it off, nothing is handed back.
    def interrupt() -> None:
        signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        changed(running, lambda: in_the_next_request(monkeypatch, running.world, interrupt))
    assert is_as_it_was(running)


def test_an_error_while_it_is_handed_back_does_not_keep_the_rest_from_being_so(
    running, monkeypatch
):
    def fail() -> None:
        raise RuntimeError("a subscriber fails")

    with pytest.raises(SwarmError, match="could not be restored"):
        changed(running, lambda: in_the_next_request(monkeypatch, running.world, fail))
    assert running.link.spin_until(lambda: running.world.status.mode == "running", 10), (
        "this is tried though the pace was not certain"
    )


def test_a_paused_world_is_paused_afterwards_even_if_it_is_still_stepping(keepers):
    keepers.world.control("pace", pace="realtime", factor=1.0)
    keepers.world.control("pause")
    assert keepers.link.spin_until(lambda: keepers.world.status.mode == "paused", 10)
    with as_it_was(keepers.world):
        keepers.world.control("step", cycles=100_000)
        assert keepers.link.spin_until(lambda: keepers.world.status.mode == "running", 10)
    assert keepers.link.spin_until(lambda: keepers.world.status.mode == "paused", 10)
