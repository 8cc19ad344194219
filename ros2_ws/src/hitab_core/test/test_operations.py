"""Operations: done once for each id, also if the process was killed, and answered as they were."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from hitab_core import Agent, BehaviorLibrary, HitabError, LibraryError, plain_domain
from hitab_core.operations import (
    BeginTraining,
    Command,
    DeleteExamples,
    DiscardTraining,
    Perform,
    Redo,
    SaveBehavior,
    Test,
    Undo,
)
from hitab_core.training.agent_database import AgentDatabase
from hitab_core.training.operation import OUTCOMES_MAX, Operation
from hitab_core.training.training_journal import TrainingJournal

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position"])
STEP = 0.1


class Cart:
    """An agent in training, whose position is its cycle."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cycle = 0
        self.agent = self._made()
        self.run()
        self.agent.do(BeginTraining("Shuttle", ["Position"]))

    def _made(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", CART)
        return Agent("cart", CART, library, self.folder / "journal")

    def run(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            self.cycle += 1
            self.agent.sense([float(self.cycle)], [], self.cycle, self.cycle * STEP)
            self.agent.tick()

    def taught(self) -> None:
        for behavior in ("Right", "Left", "Right"):
            self.run()
            self.agent.do(Command(behavior))

    def killed(self) -> None:
        self.agent.journal.close()  # as the end of a process does
        self.agent = self._made()
        self.run()

    @property
    def state(self) -> Any:
        """What operations change and kills must not."""
        session, library = self.agent.session, self.agent.library.folder
        examples = [] if session is None else list(session.examples)
        return self.agent.training, examples, sorted(p.name for p in library.rglob("*.yaml"))


@pytest.fixture
def cart(tmp_path: Path) -> Cart:
    return Cart(tmp_path)


ONCE = [
    Command("Left", id="1"),
    Undo(id="2"),
    DeleteExamples([1], id="3"),
    SaveBehavior(id="4"),
    DiscardTraining(id="5"),
    BeginTraining("Other", ["Position"], discard=True, id="6"),
]


@pytest.mark.parametrize("operation", ONCE, ids=lambda operation: operation.name)
def test_an_operation_that_is_sent_again_is_done_once(cart: Cart, operation: Operation) -> None:
    cart.taught()
    before, outcome = cart.state, cart.agent.do(operation)
    after = cart.state
    assert after != before
    for _ in range(2):
        assert cart.agent.do(operation) == outcome
        assert cart.state == after
    for _ in range(2):
        cart.killed()
        assert cart.agent.do(operation).message == "done before the restart"
        assert cart.state == after


def test_what_is_sent_again_late_is_done_once_whatever_came_between(cart: Cart) -> None:
    cart.taught()
    sent = [Command("Left", id="1"), Undo(id="2"), Redo(id="3"), Command("Right", id="4")]
    for operation in sent:
        cart.agent.do(operation)
    after = cart.state
    for again in (lambda: None, cart.killed):
        again()
        for operation in sent:
            cart.agent.do(operation)
        assert cart.state == after


def test_operations_of_different_ids_or_none_are_different(cart: Cart) -> None:
    cart.taught()
    for operation in (Undo(), Undo(), Undo(id="1")):
        cart.agent.do(operation)
    assert cart.state[1] == []


def test_a_refused_operation_may_succeed_when_it_is_sent_again(cart: Cart) -> None:
    operation = Test(id="1")
    for _ in range(2):
        with pytest.raises(HitabError, match="no example leaves Start"):
            cart.agent.do(operation)
    cart.taught()
    assert cart.agent.do(operation).message.startswith('cart is testing "Shuttle"')
    assert cart.agent.mode == "testing"


def test_a_save_that_the_disk_refused_is_made_when_it_is_sent_again(
    cart: Cart, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its record is in the journal by then."""
    cart.taught()
    before, operation = cart.state, SaveBehavior(id="1")

    def full(*_: Any) -> None:
        raise LibraryError("the disk is full")

    for again in (lambda: None, cart.killed):
        with monkeypatch.context() as patched:
            patched.setattr("hitab_core.library.change.LibraryChange.commit", full)
            with pytest.raises(LibraryError, match="the disk is full"):
                cart.agent.do(operation)
        again()
        assert cart.state == before
    assert cart.agent.do(operation).message == 'saved "Shuttle" with 6 examples'
    assert cart.state[2]


def test_a_save_whose_process_was_killed_before_it_ended_the_training_counts(
    cart: Cart, monkeypatch: pytest.MonkeyPatch
) -> None:
    cart.taught()
    operation = SaveBehavior(id="1")
    with monkeypatch.context() as patched:
        patched.setattr(TrainingJournal, "archive", _killed)
        with pytest.raises(KeyboardInterrupt):
            cart.agent.do(operation)
    cart.killed()
    assert cart.agent.do(operation).message == "done before the restart"
    assert cart.agent.training == ""
    assert cart.state[2]


def test_a_training_is_discarded_in_one_transaction(
    cart: Cart, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A kill between two would leave a training that is answered to be discarded."""
    cart.taught()
    begun, transaction = [], AgentDatabase.transaction
    monkeypatch.setattr(
        AgentDatabase, "transaction", lambda *a, **k: begun.append(1) or transaction(*a, **k)
    )
    cart.agent.do(DiscardTraining(id="1"))
    assert len(begun) == 1


def _killed(*_: Any) -> None:
    raise KeyboardInterrupt


def test_the_outcomes_of_the_last_operations_are_kept(cart: Cart) -> None:
    for number in range(OUTCOMES_MAX + 1):
        cart.agent.do(Perform(id=str(number)))
    assert "0" not in cart.agent.outcomes
    assert len(cart.agent.outcomes) == OUTCOMES_MAX


def example_of(cart: Cart, command: Command) -> Any:
    (number, *_) = cart.agent.do(command).examples
    assert cart.agent.session is not None
    return next(e for e in cart.agent.session.examples if e.number == number)


def test_an_exact_command_is_recorded_for_the_percept_seen_and_another_is_estimated(
    cart: Cart,
) -> None:
    """In a world that moves; the percepts after the one seen are not the person's."""
    cart.run(20)
    exact = example_of(cart, Command("Right", seen=cart.cycle - 2, pace=1.0, exact=True))
    assert (exact.cycle, exact.features) == (cart.cycle - 2, (cart.cycle - 2.0,))
    assert exact.ago == 0.0, "it is not late: it is for that percept"
    cart.run(20)
    late = example_of(cart, Command("Left", seen=cart.cycle - 2, pace=1.0))
    assert late.cycle == cart.cycle - 2, "nothing shows yet that the person is later than that"
    assert late.ago == pytest.approx(2 * STEP)
    cart.run(20)
    waited = example_of(cart, Command("Right"))
    assert (waited.cycle, waited.ago) == (cart.cycle, 0.0), "the situation waited"


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (Command("Left"), "cart: Start -> Left; Shuttle has 2 examples (1 default)"),
        (Command("Done"), "cart: Start -> Done; Shuttle has 1 example (0 default)"),
        (
            Command("Left", unrecorded=True),
            "cart performs Left; Shuttle has 0 examples (0 default); "
            "cart was brought into Left; no example was recorded",
        ),
    ],
)
def test_a_command_says_which_transition_it_records(
    cart: Cart, command: Command, said: str
) -> None:
    outcome = cart.agent.do(command)
    assert outcome.message == said
    assert outcome.left == ("" if command.unrecorded else "Start")


def test_a_command_is_refused_while_its_robot_is_stopped(cart: Cart) -> None:
    cart.agent.stopped = "waits to be armed"
    refused: Callable[[], Any] = lambda: cart.agent.do(Command("Left", id="1"))  # noqa: E731
    with pytest.raises(HitabError, match="waits to be armed"):
        refused()
    assert cart.state[1] == []
    cart.agent.stopped = ""
    assert refused().examples == [1, 2]
