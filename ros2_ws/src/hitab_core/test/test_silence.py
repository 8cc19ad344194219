"""What a person lets pass while watching is evidence, as far as there was time to object."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hitab_core import Agent, BehaviorLibrary, Use, plain_domain
from hitab_core.domain import Feature, FeatureKind, Scale
from hitab_core.example import Example
from hitab_core.training import Curriculum
from hitab_core.training.lateness import LateCommand, Lateness, settled

LIGHT = Feature("Light", lambda body: body.percept[1], FeatureKind.BOOLEAN)
CART = plain_domain("cart", {"Go": [1.0], "Turn": [0.0]}, ["Distance", LIGHT])
STEP = 0.1
FAR, NEAR = 8.0, 3.0


class Cart:
    """A cart that runs at a wall; there is a light."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.time, self.cycle = folder, 0.0, 0
        self.agent = self.made()
        self.agent.begin(Curriculum("Bounce", (Use("Distance"), Use("Light"))))

    def made(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", CART)
        return Agent("cart", CART, library, self.folder / "journal")

    def watch(self, distance: float, light: float, seconds: float, *, jumped: bool = True) -> None:
        for cycle in range(round(seconds / STEP)):
            self.cycle += 1
            self.time += STEP
            jumps = jumped and cycle == 0
            self.agent.sense([distance, light], [], self.cycle, self.time, jumped=jumps)
            self.agent.tick()

    def show(self, pace: float) -> None:
        """Go from far away in the dark, and turn near the wall where there is light."""
        self.watch(FAR, 0.0, 1.0)
        self.agent.command(Use("Go"), pace=pace)
        self.watch(FAR, 0.0, 2.0, jumped=False)
        self.watch(NEAR, 1.0, 0.5, jumped=False)
        self.agent.command(Use("Turn"), pace=pace)

    def let_pass(self, seconds: float) -> None:
        """Go on for a while when the light comes on, far from the wall."""
        self.watch(FAR, 0.0, 1.0)
        self.agent.command(Use("Go"))
        self.watch(FAR, 1.0, seconds, jumped=False)

    @property
    def examples(self) -> tuple[Example, ...]:
        assert self.agent.session is not None
        return self.agent.session.examples

    def turns(self, distance: float, light: float) -> bool:
        assert self.agent.session is not None
        function = self.agent.session.automaton().transitions["Go"]
        odds = function.explain([distance, light], ["Distance", "Light"]).distribution
        return odds.get("Turn", 0.0) > 0.5


@pytest.fixture
def cart(tmp_path: Path) -> Cart:
    return Cart(tmp_path)


def test_what_was_let_pass_is_learned(cart: Cart) -> None:
    cart.show(pace=1.0)
    assert cart.turns(FAR, 1.0)  # the light explains the command as well as the wall does
    cart.let_pass(5.0)
    cart.show(pace=1.0)
    assert not cart.turns(FAR, 1.0)
    assert cart.turns(NEAR, 1.0)


@pytest.mark.parametrize(("seconds", "pace"), [(0.3, 1.0), (5.0, 0.0)])
def test_silence_says_nothing_before_one_would_have_reacted_or_of_a_script(
    cart: Cart, seconds: float, pace: float
) -> None:
    cart.show(pace)
    cart.let_pass(seconds)
    cart.show(pace)
    assert cart.turns(FAR, 1.0)


def test_silence_does_not_outvote_a_command_nearby(cart: Cart) -> None:
    cart.show(pace=1.0)
    cart.watch(FAR, 0.0, 1.0)
    cart.agent.command(Use("Go"))
    cart.watch(NEAR, 1.0, 5.0, jumped=False)
    cart.show(pace=1.0)
    assert cart.turns(NEAR, 1.0)


def test_undo_takes_back_what_was_let_pass_and_a_crash_keeps_it(cart: Cart) -> None:
    cart.show(pace=1.0)
    cart.let_pass(5.0)
    before = cart.examples
    cart.show(pace=1.0)
    learned = cart.examples
    cart.agent.journal.close()
    cart.agent = cart.made()
    assert cart.examples == learned
    assert cart.agent.session is not None
    for _ in range(2):
        cart.agent.session.undo()
    assert cart.examples == before


def test_what_was_let_pass_is_not_what_a_late_command_was_meant_for() -> None:
    delays, places = np.arange(2.0, 0.0, -0.1), np.arange(20)
    values = np.column_stack([places >= 15, places >= 10]).astype(np.float64)  # light, sound
    command = LateCommand("Go", "Turn", delays, values)
    bright = np.column_stack([np.ones(20), np.zeros(20)])
    silent = [LateCommand("Go", "", np.linspace(6.0, 4.0, 20), bright)] * 2
    scales = [Scale(FeatureKind.BOOLEAN)] * 2
    assert settled([command], scales, Lateness())[0] == [15]
    assert settled([command], scales, Lateness(), silent)[0] == [10]
