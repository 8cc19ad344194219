"""What a person lets pass while watching is no reason for the person's commands."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import numpy as np
import pytest

from hitab_core import Agent, BehaviorLibrary, Use, plain_domain
from hitab_core.domain import Feature, FeatureKind, Scale
from hitab_core.training import Curriculum
from hitab_core.training.lateness import LateCommand, Lateness, settled
from hitab_core.training.moments import Moment
from hitab_core.training.silence import Silence

LIGHT, SOUND = (
    Feature(name, lambda body, i=i: body.percept[i], FeatureKind.BOOLEAN)
    for i, name in enumerate(("Light", "Sound"))
)
CART = plain_domain("cart", {"Go": [1.0], "Stop": [0.0]}, [LIGHT, SOUND])
STEP = 0.1


class Cart:
    """A cart that stops at a sound, which comes half a second before the light."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.time, self.cycle = folder, 0.0, 0
        self.agent = self.made()
        self.agent.begin(Curriculum("Listen", (Use("Light"), Use("Sound"))))

    def made(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", CART)
        return Agent("cart", CART, library, self.folder / "journal")

    def watch(self, seconds: float, *, light: bool = False, sound: bool = False) -> None:
        for _ in range(round(seconds / STEP)):
            self.cycle += 1
            self.time += STEP
            self.agent.sense([light, sound], [], self.cycle, self.time)
            self.agent.tick()

    def begin(self) -> None:
        self.agent.sense([0.0, 0.0], [], self.cycle, self.time, jumped=True)
        self.agent.command(Use("Go"))

    def stop(self) -> tuple[float, ...]:
        """Show the stop, a second late; return for what it is taken to have been meant."""
        self.begin()
        self.watch(2.0)
        self.watch(0.5, sound=True)
        self.watch(0.5, light=True, sound=True)
        return self.agent.command(Use("Stop"), pace=1.0)[0].features

    def let_pass(self, seconds: float) -> None:
        self.begin()
        self.watch(1.0)
        self.watch(seconds, light=True)


@pytest.fixture
def cart(tmp_path: Path) -> Cart:
    return Cart(tmp_path)


def test_what_was_let_pass_is_not_what_a_late_command_was_meant_for(cart: Cart) -> None:
    assert cart.stop() == (1.0, 1.0)  # as if the person answered to the light, fast
    for _ in range(3):
        cart.let_pass(5.0)
    assert cart.stop() == (0.0, 1.0)


def test_silence_says_nothing_before_one_would_have_reacted(cart: Cart) -> None:
    for _ in range(3):
        cart.let_pass(0.3)
    assert cart.stop() == (1.0, 1.0)


def test_nobody_is_known_to_have_watched_long_ago(cart: Cart) -> None:
    for _ in range(3):
        cart.let_pass(5.0)
    cart.begin()
    cart.watch(60.0)
    assert cart.stop() == (1.0, 1.0)


def test_a_crash_forgets_nothing_that_was_let_pass(cart: Cart) -> None:
    for _ in range(3):
        cart.let_pass(5.0)
    cart.stop()
    cart.agent.journal.close()
    cart.agent = cart.made()
    assert cart.agent.session is not None
    assert len(cart.agent.session.perception.silence.kept) >= 3
    assert cart.stop() == (0.0, 1.0)


def test_a_late_command_answers_to_what_does_not_hold_in_silence() -> None:
    delays, places = np.arange(2.0, 0.0, -0.1), np.arange(20)
    values = np.column_stack([places >= 15, places >= 10]).astype(np.float64)  # light, sound
    command = LateCommand("Go", "Turn", delays, values)
    bright = np.column_stack([np.ones(20), np.zeros(20)])
    silent = [LateCommand("Go", "", np.linspace(6.0, 4.0, 20), bright)] * 2
    scales = [Scale(FeatureKind.BOOLEAN)] * 2
    assert settled([command], scales, Lateness())[0] == [15]
    assert settled([command], scales, Lateness(), silent)[0] == [10]


def test_hours_in_one_state_take_no_more_memory_than_minutes() -> None:
    taken = []
    for cycles in (2_000, 50_000):
        tracemalloc.start()
        silence = Silence()
        for cycle in range(cycles):
            silence.see(Moment(cycle, cycle * STEP, "Go", (float(cycle),)))
        taken.append(tracemalloc.get_traced_memory()[0])
        tracemalloc.stop()
        silence.end()
        (stretch,) = silence.broken(cycles * STEP, pace=1.0)
        assert stretch.moments[0].cycle == 0
        assert stretch.moments[-1].cycle > 0.8 * cycles
    assert taken[1] < 2 * taken[0]
