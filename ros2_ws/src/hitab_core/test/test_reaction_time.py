"""Commands that come late: each is recorded with the situation in which it was due."""

from __future__ import annotations

import json
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from hitab_core import (
    Agent,
    BehaviorLibrary,
    HitabError,
    Term,
    TrainingError,
    plain_domain,
)
from hitab_core.example import Example
from hitab_core.training import Curriculum
from hitab_core.training.events import Given
from hitab_core.training.percepts import PerceptRecord, nearest

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0]}, ["Position", "Speed"])
STEP = 0.1


class Driven:
    """An agent whose position is its cycle, and whose speed is its cycle squared."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cycle = 0
        self.agent = self.made()
        self.agent.begin(Curriculum("Shuttle", (Term("Position"),)))

    def made(self) -> Agent:
        library = BehaviorLibrary(self.folder / "library", CART)
        return Agent("cart", CART, library, self.folder / "journal")

    def run(self, cycles: int = 1, *, jumped: bool = False, position: float | None = None) -> None:
        for _ in range(cycles):
            self.cycle += 1
            where = float(self.cycle) if position is None else position
            values = [where, float(self.cycle**2)]
            self.agent.sense(values, [], self.cycle, self.cycle * STEP, jumped=jumped)
            self.agent.tick()

    def command(self, label: str, ago: float = 0.0, seen: int = 0) -> Example:
        """Command with what was seen in a cycle, or some seconds ago."""
        seen = seen or (self.cycle - round(ago / STEP) if ago else 0)
        return self.agent.command(Term(label), Given(seen=seen))[0]

    def examples(self) -> list[tuple[int, str, float, str, str]]:
        assert self.agent.session is not None
        return [
            (e.number, e.state, e.features[0], e.next_state, e.kind.value)
            for e in self.agent.session.examples
        ]

    def restarted(self) -> None:
        self.agent.journal.close()
        self.agent = self.made()


@pytest.fixture
def cart(tmp_path: Path) -> Driven:
    return Driven(tmp_path)


def test_a_command_is_recorded_with_the_situation_for_which_it_was_due(cart: Driven) -> None:
    cart.run(10)
    taught = cart.command("Right", ago=0.4)
    assert (taught.features, taught.cycle, taught.state) == ((6.0,), 6, "Start")
    assert taught.ago == pytest.approx(0.4)
    assert cart.examples()[1] == (2, "Right", 6.0, "Right", "default")
    assert cart.agent.active_path == ["Right"], "it is performed now"


def test_the_nearest_moment_counts_and_of_two_as_near_the_later_one() -> None:
    kept = [PerceptRecord(i, i * STEP, "Go", (0.0,)) for i in range(8)]
    times = [0.0, 0.11, 0.19, 0.25, 0.26, 9.0, -1.0]
    assert [nearest(kept, time).cycle for time in times] == [0, 1, 2, 3, 3, 7, 0]


def test_the_time_counts_from_what_the_demonstrator_saw(cart: Driven) -> None:
    cart.run(10)
    assert cart.command("Right", seen=8).cycle == 8
    assert cart.command("Left", seen=9).cycle == 9


def test_a_command_is_taken_with_the_state_that_was_active_then(cart: Driven) -> None:
    """Both come late by the same time, so the second one leaves what the first one began."""
    cart.run(10)
    cart.command("Right", ago=0.4)
    cart.run(2)
    cart.command("Left", ago=0.4)
    cart.run(5)
    cart.command("Right", ago=0.9)
    assert [(e[1], e[2], e[3]) for e in cart.examples() if e[4] == "demonstrated"] == [
        ("Start", 6.0, "Right"),
        ("Right", 8.0, "Left"),
        ("Left", 8.0, "Right"),
    ], "and no command was due before the one that was given before it"


def test_after_an_undo_the_state_of_that_time_is_as_if_nothing_had_been_commanded(
    cart: Driven,
) -> None:
    cart.run(10)
    cart.command("Right", ago=0.4)
    cart.run(2)
    cart.agent.session.undo()
    assert cart.command("Left", ago=0.3).state == "Start"


def test_no_command_was_due_before_its_situation_came_about(cart: Driven) -> None:
    cart.run(10)
    cart.run(jumped=True)  # something was placed
    cart.run(2)
    assert cart.command("Right", ago=1.0).cycle == 11
    cart.run()
    cart.agent.restart(1, 1)  # a new episode
    cart.run()
    assert cart.command("Left", seen=14).cycle == 14


def test_what_was_perceived_before_and_during_a_test_is_known_to_who_takes_over(
    cart: Driven,
) -> None:
    cart.run(60)
    cart.command("Right")
    cart.run(20)
    cart.command("Left")
    cart.run(15)
    cart.agent.test()
    cart.run(15)
    cart.agent.take_over()
    cart.run(5)
    assert cart.command("Right", seen=90).cycle == 90
    assert cart.command("Left", seen=100).cycle == 100


def test_a_command_can_be_retimed_also_after_a_crash_and_that_undone(cart: Driven) -> None:
    cart.run(10)
    cart.command("Right")
    cart.run(3)
    cart.command("Left", ago=0.1)
    session = cart.agent.session
    assert session is not None
    session.retime([3], 0.5)
    assert cart.examples()[2] == (3, "Start", 8.0, "Left", "demonstrated")
    assert cart.examples()[3][2] == 8.0, "the default example is of the same situation"
    session.undo()
    assert cart.examples()[2] == (3, "Right", 12.0, "Left", "demonstrated")
    cart.restarted()
    session = cart.agent.session
    assert session is not None
    session.retime([4], 0.2)
    assert cart.examples()[2] == (3, "Right", 11.0, "Left", "demonstrated")
    assert session.log.history.done[-1] == "example 4 due 0.2 s before its command"
    with pytest.raises(TrainingError, match=r"is too long ago: .*; give a number from 0 to"):
        session.retime([3], 9.0)


def test_a_command_in_a_world_that_stood_still_was_not_late(cart: Driven) -> None:
    cart.run(1)
    cart.command("Right")
    session = cart.agent.session
    assert session is not None
    with pytest.raises(TrainingError, match="example 1 was commanded while the world stood still"):
        session.retime([1], 0.2)
    session.retime([1], 0.0)


def test_features_are_exchanged_without_demonstrating_again(cart: Driven) -> None:
    cart.run(4)
    cart.command("Right")
    cart.run(4)
    cart.command("Left")
    session = cart.agent.session
    assert session is not None
    cart.agent.test()
    session.choose_features((Term("Speed"),))
    assert [e.features for e in session.examples][::2] == [(16.0,), (64.0,)]
    # What is being tested decides by the new feature at once.
    tree = session.running.automaton.features
    assert tree == (Term("Speed"),)
    session.undo()
    assert session.curriculum.features == (Term("Position"),)
    assert [e.features for e in session.examples][::2] == [(4.0,), (8.0,)]
    session.redo()
    cart.restarted()
    session = cart.agent.session
    assert session is not None
    assert session.curriculum.features == (Term("Speed"),)


def test_what_was_saved_can_be_trained_again_with_other_features(cart: Driven) -> None:
    cart.run(4)
    cart.command("Right")
    cart.run(4)
    cart.command("Left")
    cart.agent.save()
    text = cart.agent.library.on_disk.file("Shuttle").read_text()
    assert "readable:" in text
    again = Agent("cart", CART, BehaviorLibrary(cart.folder / "library", CART))
    again.begin(Curriculum("", (Term("Speed"), Term("Position"))), resume="Shuttle")
    assert again.session is not None
    assert [e.features for e in again.session.examples][::2] == [(16.0, 4.0), (64.0, 8.0)]


def test_a_feature_without_any_value_is_refused_by_name(cart: Driven) -> None:
    cart.run(4)
    cart.command("Right")
    agent, session = cart.agent, cart.agent.session
    assert session is not None
    before = cart.examples()
    # A training by an older HiTAB kept no readings.
    agent.journal.close()
    with closing(sqlite3.connect(cart.folder / "journal" / "agent.db")) as tables:
        texts = [text for (text,) in tables.execute("SELECT text FROM record ORDER BY key")]
    assert json.loads(texts[1])["examples"][0]["readings"][0] == 4.0
    session.log.make(
        session.log.replacement(
            [
                Example(e.state, e.features, e.next_state, e.kind, e.number, e.command)
                for e in session.examples
            ],
            "older",
        )
    )
    with pytest.raises(TrainingError, match="have no value for Speed"):
        session.choose_features((Term("Speed"),))
    assert cart.examples() == before


def test_a_command_outranks_the_default_example_that_it_contradicts(cart: Driven) -> None:
    cart.run(4)
    cart.command("Right")
    cart.command("Left")  # at once put right
    kinds = {e.number: e.kind.value for e in cart.agent.session.examples}
    assert kinds == {
        1: "demonstrated", 2: "superseded", 3: "demonstrated", 4: "default",
    }  # fmt: skip
    cart.agent.test(restart=True)
    for _ in range(50):  # no coin toss
        cart.agent.restart(1, 1)
        cart.agent.tick()
        cart.agent.tick()
        assert cart.agent.active_path == ["Left"]
    cart.agent.session.delete([3])
    assert [e.kind.value for e in cart.agent.session.examples] == [
        "demonstrated", "default", "default",
    ]  # fmt: skip


def test_the_time_in_a_state_counts_from_when_its_command_was_due(cart: Driven) -> None:
    session = cart.agent.session
    assert session is not None
    session.choose_features((Term("SecondsInState"),))
    cart.run(10)
    cart.command("Right", ago=0.4)
    cart.run(5)
    assert cart.command("Left").features[0] == pytest.approx(0.9)
    cart.run(5)
    cart.command("Right", ago=0.3)
    cart.run()
    cart.command("Left", ago=0.2)
    assert session.examples[-2].features[0] == pytest.approx(0.2)


def test_what_was_seen_before_the_episode_is_not_recorded_in_it(cart: Driven) -> None:
    cart.run(10)
    cart.agent.restart(1, 2)
    cart.run(3)
    with pytest.raises(TrainingError, match="cycle 9, but a new episode has begun in cycle 10"):
        cart.command("Right", seen=9)
    assert cart.examples() == []
    assert cart.command("Right", seen=10).cycle == 10


def test_a_late_command_counts_for_now_if_nothing_was_perceived_since_the_training_began(
    cart: Driven,
) -> None:
    """As in a paused world: nothing has changed since."""
    cart.run(5)
    cart.agent.begin(Curriculum("Other", (Term("Position"),)))
    taught = cart.command("Right", ago=0.3, seen=5)
    assert (taught.features, taught.ago) == ((5.0,), 0.0)


def test_a_state_that_the_agent_is_brought_into_teaches_nothing_and_is_what_is_corrected(
    tmp_path,
):
    driven = Driven(tmp_path)
    driven.run()
    driven.command("Left")
    driven.run(5)
    taught = driven.examples()
    assert driven.agent.command(Term("Right"), unrecorded=True) == []
    assert driven.agent.active_path == ["Right"]
    assert driven.examples() == taught
    assert driven.agent.session.note == "was brought into Right; no example was recorded"
    driven.run(2)
    # Before that, it was in a state that the person did not mean: no reaction is so long.
    corrected = driven.command("Left", ago=0.4)
    assert (corrected.state, corrected.next_state) == ("Right", "Left")
    assert corrected.cycle == 6
    driven.restarted()
    assert len(driven.examples()) == len(taught) + 2


def test_an_agent_is_brought_into_a_state_only_in_training_and_only_into_one_that_there_is(
    tmp_path,
):
    driven = Driven(tmp_path)
    driven.run()
    with pytest.raises(HitabError, match='unknown behavior "Rihgt"'):
        driven.agent.command(Term("Rihgt"), unrecorded=True)
    driven.command("Left")
    driven.agent.test()
    with pytest.raises(TrainingError, match="is being tested"):
        driven.agent.command(Term("Right"), unrecorded=True)
