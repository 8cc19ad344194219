"""Commands for a percept that is past equal commands for which the world had stood still."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from hitab_core import (
    Agent,
    BehaviorLibrary,
    Example,
    Given,
    Term,
    TrainingError,
    TransitionTree,
    plain_domain,
)
from hitab_core.training import Curriculum
from hitab_core.training.past import PAST_SECONDS

CART = plain_domain("cart", {"Left": [-1.0], "Right": [1.0], "Stay": [0.0]}, ["Position"])
FEATURES = (Term("Position"), Term("SecondsInState"), Term("Done"))
STEP = 0.1


class Course:
    """A cart that is carried along: its position is its cycle's square."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.cycle = 0
        self.agent = self.made()
        self.agent.begin(Curriculum("Shuttle", FEATURES))

    def made(self) -> Agent:
        return Agent("cart", CART, BehaviorLibrary(self.folder / "lib", CART), self.folder / "log")

    def play(self, commands: dict[int, str], until: int) -> None:
        """Play on; each command is given while the world stands still at its cycle."""
        while self.cycle < until:
            self.cycle += 1
            self.agent.sense([self.cycle**2 / 7], [], self.cycle, self.cycle * STEP)
            if self.cycle in commands:
                self.command(commands[self.cycle], self.cycle)
            self.agent.tick()

    def command(self, label: str, cycle: int) -> list[Example]:
        return self.agent.command(Term(label), Given(seen=cycle, pace=1.0, exact=True))

    @property
    def session(self):
        assert self.agent.session is not None
        return self.agent.session

    def taught(self) -> list[Example]:
        """Return the examples without their numbers, which tell when they were given."""
        blank = [replace(e, number=0, command=0) for e in self.session.examples]
        return sorted(blank, key=lambda e: (e.cycle, e.is_default))

    def trees(self) -> dict[str, str]:
        found = {}
        for state, tree in self.session.automaton().transitions.items():
            assert isinstance(tree, TransitionTree)
            found[state] = tree.digest()
        return found


@pytest.fixture
def course(tmp_path: Path) -> Course:
    return Course(tmp_path / "past")


@pytest.fixture
def in_time(tmp_path: Path) -> Course:
    return Course(tmp_path / "in_time")


@pytest.mark.parametrize("late", [1, 30, 590])
def test_a_command_for_the_past_records_and_teaches_what_one_in_time_does(
    course: Course, in_time: Course, late: int
) -> None:
    in_time.play({5: "Right", 9: "Left"}, until=9 + late)
    course.play({5: "Right"}, until=9 + late)
    course.command("Left", 9)
    assert course.session.examples == in_time.session.examples, "bit for bit, with the numbers"
    assert course.trees() == in_time.trees()
    assert course.session.history.kept_around(2) == in_time.session.history.kept_around(2)
    assert course.agent.active_path == ["Left"], "nothing else was commanded since: it obeys"


def test_later_commands_stay_as_they_are_and_the_agent_continues(
    course: Course, in_time: Course
) -> None:
    in_time.play({5: "Right", 9: "Left"}, until=12)
    course.play({5: "Right", 20: "Stay"}, until=40)
    later = course.session.examples[2:]
    recorded = course.command("Left", 9)
    missing = [e for e in in_time.session.examples if e.cycle == 9]
    assert [
        replace(e, number=n.number, command=n.command)
        for e, n in zip(missing, recorded, strict=True)
    ] == recorded
    assert course.session.examples[2:4] == later
    assert course.agent.active_path == ["Stay"]
    course.session.undo()
    assert course.agent.active_path == ["Stay"]
    assert course.session.examples[2:] == later
    course.session.redo()
    assert course.agent.active_path == ["Stay"]
    assert course.session.examples[4:] == tuple(recorded)


def test_the_state_is_the_one_that_was_active_then_not_the_one_a_late_command_says(
    course: Course,
) -> None:
    course.play({5: "Right"}, until=20)
    course.agent.command(Term("Left"), Given(seen=10))
    assert course.command("Stay", 15)[0].state == "Right"
    course.play({}, until=21)
    assert course.command("Stay", 21)[0].state == "Stay", "and this one is in time"


def test_the_order_of_commands_for_the_past_does_not_matter(
    course: Course, in_time: Course
) -> None:
    for one, order in (
        (course, ((9, "Left"), (14, "Stay"))),
        (in_time, ((14, "Stay"), (9, "Left"))),
    ):
        one.play({5: "Right"}, until=30)
        for cycle, label in order:
            one.command(label, cycle)
        assert one.agent.active_path == ["Stay"], "the one for the later moment"
    assert course.taught() == in_time.taught()
    assert course.trees() == in_time.trees()


def test_what_a_test_did_is_corrected_in_the_state_of_that_time(course: Course) -> None:
    course.play({5: "Right", 9: "Left"}, until=30)
    course.agent.test(restart=True)
    course.play({}, until=40)
    before = course.session.history.past.at(33)
    doing = course.agent.active_path
    with pytest.raises(TrainingError, match="is being tested"):
        course.command("Stay", 33)
    course.agent.take_over()
    (corrected, *_) = course.command("Stay", 33)
    assert (corrected.state, corrected.cycle) == (before.state, 33)
    assert corrected.kind.value == "correction"
    assert course.agent.active_path == doing, "it was taken over since"


@pytest.mark.parametrize(("back", "stays"), [(1, False), (10, True)])
def test_going_back_keeps_what_was_commanded_before_and_forgets_the_rest(
    course: Course, back: int, stays: bool
) -> None:
    course.play({7: "Right", 14: "Left"}, until=20)
    course.agent.go_back(back)
    course.cycle = back - 1
    course.play({}, until=13)
    course.command("Stay", 5)
    assert course.agent.active_path == (["Right"] if stays else ["Stay"])


def test_moments_before_an_episode_a_jump_or_the_last_minute_are_refused(course: Course) -> None:
    course.play({5: "Right"}, until=20)
    course.agent.sense([1.0], [], 21, 2.1, jumped=True)
    course.cycle = 21
    course.play({}, until=30)
    examples = course.session.examples
    with pytest.raises(TrainingError, match=r"cycle 20 is not kept.* begin at cycle 21"):
        course.command("Left", 20)
    course.agent.restart(1, 1)
    course.play({}, until=31)
    with pytest.raises(TrainingError, match="a new episode has begun in cycle 30"):
        course.command("Left", 29)
    minute = round(PAST_SECONDS / STEP)
    course.play({}, until=33 + minute)
    with pytest.raises(TrainingError, match="keeps the last 60 s"):
        course.command("Left", 31)
    assert course.session.examples == examples


def test_commands_for_the_past_come_back_after_a_crash(course: Course) -> None:
    course.play({5: "Right", 20: "Stay"}, until=40)
    course.command("Left", 9)
    examples = course.session.examples
    course.agent.journal.close()
    course.agent = course.made()
    assert course.session.examples == examples
    course.session.undo()
    assert course.session.examples == examples[:4]
    assert course.agent.active_path == ["Start"], "not in a state that it did not leave for it"
