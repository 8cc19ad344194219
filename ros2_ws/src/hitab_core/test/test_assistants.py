"""Assistants of a training: each subscribes, can be left out by name, and is a guest."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import pytest

from hitab_core import Agent, BehaviorLibrary, Given, Term, TrainingSession, plain_domain
from hitab_core.training import Curriculum
from hitab_core.training.events import CommandGiven, Proposal
from hitab_core.training_session import ASSISTANTS

CART = plain_domain("cart", {"Go": [1.0], "Turn": [0.0]}, ["Distance"])


WALL = 4.0
"""Where its person wants it to turn, m."""


class Cart:
    """A cart that drives at a wall; its person turns it a second too late."""

    def __init__(self, folder: Path, without: Collection[str] = ()) -> None:
        library = BehaviorLibrary(folder / "library", CART)
        self.agent = Agent("cart", CART, library, folder / "journal", without=without)
        if self.agent.session is None:
            self.agent.begin(Curriculum("Bounce", (Term("Distance"),)))
        self.cycle = 0

    @property
    def session(self) -> TrainingSession:
        assert self.agent.session is not None
        return self.agent.session

    def see(self, distance: float, *, jumped: bool = False) -> None:
        self.cycle += 1
        self.agent.sense([distance], [], self.cycle, self.cycle * 0.1, jumped=jumped)
        self.agent.tick()

    def drive(self, speed: float = 0.1) -> None:
        self.see(WALL + 20 * speed, jumped=True)
        self.agent.command(Term("Go"))
        for step in range(-19, 11):
            self.see(WALL - speed * step)
        self.agent.command(Term("Turn"), Given(pace=1.0))


def test_without_the_estimate_of_reactions_a_late_command_means_what_was_seen(
    tmp_path: Path,
) -> None:
    helped, alone = Cart(tmp_path / "1"), Cart(tmp_path / "2", without=["reaction"])
    for speed in (0.1, 0.05, 0.15, 0.2, 0.12):
        helped.drive(speed)
        alone.drive(speed)
    seen, meant = (
        [e.features[0] for e in cart.session.examples if (e.state, e.next_state) == ("Go", "Turn")]
        for cart in (alone, helped)
    )
    assert seen == pytest.approx([WALL - 10 * speed for speed in (0.1, 0.05, 0.15, 0.2, 0.12)])
    assert all(abs(there - WALL) < 0.5 for there in meant)
    assert alone.agent.people == {}


def test_each_assistant_can_be_left_out_and_the_others_go_on(tmp_path: Path) -> None:
    for number, without in enumerate([ASSISTANTS, *([name] for name in ASSISTANTS)]):
        cart = Cart(tmp_path / str(number), without)
        cart.drive()
        for distance, commands in ((2.0, "Go Turn Go"), (5.0, "Go Turn")):  # a loop, a clash
            cart.see(distance, jumped=True)
            for behavior in commands.split():
                cart.agent.command(Term(behavior))
        cart.agent.test(restart=True)
        assert bool(cart.session.remarks(look=True)) == ("loops" not in without)
        assert any("you commanded" in q.text for q in cart.session.questions.find()) == (
            "questions" not in without
        )
        assert ("" in cart.agent.people) == ("reaction" not in without)


def test_a_training_that_had_assistants_goes_on_without_them_after_a_crash(
    tmp_path: Path,
) -> None:
    cart = Cart(tmp_path)
    cart.drive()
    before = cart.session.examples
    cart.agent.journal.close()
    again = Cart(tmp_path, without=ASSISTANTS)
    assert again.session.examples == before
    again.session.undo()
    assert len(again.session.examples) == len(before) - 2


def test_an_assistant_that_fails_changes_nothing(tmp_path: Path) -> None:
    cart, plain = Cart(tmp_path / "1"), Cart(tmp_path / "2")

    def fail(*_: object) -> None:
        raise RuntimeError("an assistant fails")

    for event in vars(cart.session.events).values():
        event.subscribe(fail)
    for one in (cart, plain):
        one.drive()
        one.agent.test(restart=True)
        one.see(6.0)
    assert cart.session.examples == plain.session.examples
    assert cart.agent.active_path == plain.agent.active_path == ["Go"]


def test_anybody_may_subscribe_and_propose_the_moment_of_a_command(tmp_path: Path) -> None:
    cart = Cart(tmp_path, without=ASSISTANTS)
    history = cart.session.history

    def propose(command: CommandGiven) -> Proposal | None:
        if command.label != "Turn":
            return None
        return Proposal(history.at(0.5), record={"proposed_by": "a test"})

    cart.session.events.commanded.subscribe(propose)
    steps: list[str] = []
    cart.session.events.changed.subscribe(lambda record: steps.append(record["do"]))
    cart.drive()
    (turn, *_) = [e for e in cart.session.examples if e.next_state == "Turn"]
    assert turn.features == pytest.approx([WALL - 0.5])
    assert turn.ago == pytest.approx(0.5)
    cart.session.undo()
    assert steps == ["command", "command", "undo"]
